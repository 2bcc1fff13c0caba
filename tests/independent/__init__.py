"""A simulator to judge the package by: real geometry of sensors and aircraft on the round earth.

It shares no code with `probreg`, so that an error of geometry cannot hide by being made twice;
numpy and pyproj only. Azimuths are clockwise from the true north of the sensor, heights are above
the ellipsoid, metres and radians inside.
"""
