"""What makes a gait: the rules, with every threshold (docs/reference/gaits.md tells why)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ...parameters import Checked, parameter

STILL, UNCLEAR = "still", "unclear"
SWIMMING = ("protrusions", "undulation", "jellyfish", "peristalsis")  # the last is not in the paper
WALKING = ("jump", "run", "mass shift")


@dataclass(frozen=True)
class Rules(Checked):
    """Thresholds of the classifier."""

    least_amplitude: float = parameter(0.02, 0.0, 1.0, "", "mean amplitude of e - c below which muscles are still")
    least_travel: float = parameter(0.2, 0.0, 1e6, "m", "way in the second half below which the body is still")
    least_coherence: float = parameter(0.25, 0.0, 1.0, "", "share of the muscles' variance at one rhythm, for a gait")
    passive_share: float = parameter(0.5, 0.0, 1.0, "", "protrusions: share of cells up to which the motion is local")
    limb_thickness: float = parameter(2.4, 1.0, 100.0, "m", "protrusions: a limb is thinner than this, the body is not")
    limb_lead: float = parameter(1.5, 1.0, 1e3, "", "protrusions: power of the sway of a limb's cell, relative to others")
    limb_power: float = parameter(0.4, 0.0, 1.0, "", "protrusions: share of the limbs in the power of the sway")
    antiphase: float = parameter(2 * math.pi / 3, 0.0, math.pi, "rad", "undulation: least phase shift between the sides")
    in_phase: float = parameter(math.pi / 3, 0.0, math.pi, "rad", "jellyfish, peristalsis: most phase shift between the sides")
    agreement: float = parameter(0.3, 0.0, 1.0, "", "of the cells on such a shift")
    slender: float = parameter(1.25, 1.0, 100.0, "", "undulation: least ratio of length to width, along the way")
    synchrony: float = parameter(0.7, 0.0, 1.0, "", "jellyfish: of muscles and of chambers")
    pulsation: float = parameter(0.02, 0.0, 1.0, "", "jellyfish: amplitude of the body's area, relative to the area")
    wave_fit: float = parameter(0.8, 0.0, 1.0, "", "peristalsis: least fit of a plane wave to the phases")
    contact_height: float = parameter(1e-3, 0.0, 1.0, "m", "above the ground that still touch it")
    least_duty: float = parameter(0.05, 0.0, 1.0, "", "share of the time for which a cell of a foot touches")
    foot_gap: float = parameter(1.5, 0.0, 100.0, "m", "along the ground, between two feet")
    least_flight: float = parameter(0.05, 0.0, 1.0, "", "jump, run: share of the time in the air; below it contact is kept")
    alternation: float = parameter(-0.5, -1.0, 0.0, "", "run: most association of the contacts of the end feet")
    most_duty: float = parameter(0.6, 0.0, 1.0, "", "run: mean share of the time for which a foot stands; more is creeping")
    least_shift: float = parameter(0.01, 0.0, 1.0, "", "mass shift: amplitude of the mass over its support, in body lengths")


def _rhythmic(gait, rules: Rules):
    """(name, why) of what is no gait, or None."""
    if not gait.amplitude >= rules.least_amplitude:
        return STILL, f"muscles beat by {gait.amplitude:.2g}"
    if not gait.travel >= rules.least_travel:
        return STILL, f"the body gets {gait.travel:.2g} m far in the second half"
    if not gait.coherence >= rules.least_coherence:
        return UNCLEAR, f"no common rhythm: coherence {gait.coherence:.2f}"
    return None


def classify_swimmer(gait: Any, rules: Rules = Rules()) -> tuple[str, str]:
    """(name, why).  Args: gait: see `analysis.Gait`."""
    none = _rhythmic(gait, rules)
    if none:
        return none
    agree = gait.lateral_agreement >= rules.agreement
    shift = f"sides {math.degrees(gait.lateral_shift):.0f} degrees apart"
    if gait.moving_share <= rules.passive_share:
        return "protrusions", f"{gait.moving_share:.0%} of the cells do the moving"
    if agree and gait.lateral_shift >= rules.antiphase and gait.bending > 0 and gait.length >= rules.slender * gait.width:
        return "undulation", f"{shift}, {gait.length / gait.width:.1f} times as long as wide"
    if gait.limb_lead >= rules.limb_lead and gait.limb_power >= rules.limb_power and gait.synchrony < rules.synchrony:
        return "protrusions", f"limbs have {gait.limb_power:.0%} of the sway"
    together = min(gait.synchrony, gait.area_synchrony)
    if agree and gait.lateral_shift <= rules.in_phase and together >= rules.synchrony and gait.pulsation >= rules.pulsation:
        return "jellyfish", f"all pulse together ({together:.2f}), the area by {gait.pulsation:.0%}"
    travels = gait.gradient_fit >= rules.wave_fit and abs(gait.gradient_along) > abs(gait.gradient_across)
    if agree and gait.lateral_shift <= rules.in_phase and together < rules.synchrony and travels:
        return "peristalsis", f"{shift}, a wave of {abs(gait.gradient_along):.2g} rad/m along the body"
    return UNCLEAR, f"{shift} (agreement {gait.lateral_agreement:.2f}), synchrony {gait.synchrony:.2f}"


def classify_walker(gait: Any, rules: Rules = Rules()) -> tuple[str, str]:
    """(name, why).  Args: gait: see `analysis.Gait`."""
    none = _rhythmic(gait, rules)
    if none:
        return none
    if gait.feet > 1 and gait.support <= rules.alternation and gait.duty <= rules.most_duty:
        return "run", f"the end feet alternate ({gait.support:.2f}), each stands {gait.duty:.0%} of the time"
    if gait.flight >= rules.least_flight:
        return "jump", f"{gait.flight:.0%} of the time in the air"
    if gait.mass_shift >= rules.least_shift * gait.length:
        return "mass shift", f"contact is kept, the mass moves {gait.mass_shift:.2g} m to and fro over it"
    return UNCLEAR, f"contact is kept, the mass moves {gait.mass_shift:.2g} m to and fro over it"
