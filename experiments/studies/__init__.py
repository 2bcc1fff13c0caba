"""One study a module: `Config`, `PROFILES`, `GRID` and `replicate(config, rng)`."""
