"""Noise laws, one a module: density, equivalent weight and sampler written once.

========================  =====================================  ========================
law                       weight w(d)                            density
========================  =====================================  ========================
Gaussian()                1                                      yes, scale mixture
Hyperbolic(mu)            1 / sqrt(d^2 + mu^2)                   yes, scale mixture
StudentT(nu)              (nu + m) / (nu + d^2)                  yes, scale mixture
Contaminated(rate, scale) posterior mean of the precision        yes, scale mixture
Huber(k)                  min(1, k / d)                          yes
Igg3(k0, k1)              1, falling, 0                          no
HardReject(k)             1, 0                                   no
Tukey(c)                  (1 - d^2 / c^2)^2, 0                   no
========================  =====================================  ========================
"""

from probreg.noise._checks import require_law, require_scalar_law
from probreg.noise._compiled import LawNumbers, apply_same, compile_scalar
from probreg.noise._law import NoiseLaw, per_component
from probreg.noise._rejection import RejectionRule
from probreg.noise._scale_mixture import Mixture, MixtureCounts, ScaleMixture
from probreg.noise.contaminated import Contaminated
from probreg.noise.gaussian import Gaussian
from probreg.noise.hard_reject import HardReject
from probreg.noise.huber import Huber
from probreg.noise.hyperbolic import Hyperbolic
from probreg.noise.igg3 import Igg3
from probreg.noise.student_t import StudentT
from probreg.noise.tukey import Tukey

__all__ = [
    "Contaminated",
    "Gaussian",
    "HardReject",
    "Huber",
    "Hyperbolic",
    "Igg3",
    "LawNumbers",
    "Mixture",
    "MixtureCounts",
    "NoiseLaw",
    "RejectionRule",
    "ScaleMixture",
    "StudentT",
    "Tukey",
    "apply_same",
    "compile_scalar",
    "per_component",
    "require_law",
    "require_scalar_law",
]
