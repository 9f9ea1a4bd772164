"""The command ``robotics certify``: how fast and from where a tracking law provably converges."""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.commands.shared import check_plot
from fuzzy.shell.options import FieldOptions, Json, Shown, argument, option
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown
from fuzzy.words import listed
from robotics.commands.completion import controllers, robots, scenarios
from robotics.tables.texts import TextFile

if TYPE_CHECKING:
    import numpy as np

    from robotics.laws.tracking.lyapunov import Lyapunov
    from robotics.plugins.certificates.certificate import Certificate, SectorModel
    from robotics.plugins.certificates.loopmodel import LoopModel
    from robotics.simulation.scenario.robots import RobotModel
    from robotics.world.vehicle.robot import Robot

_TEXTS = TextFile("robotics.plugins.certificates")
_DISTANCES = (0.0, 10.0)  # m


def certify(
    loop: Annotated[
        str | None,
        argument(
            "A law that corrects its reference: name, name:gain=value, mine.fis. Default: what --law says.",
            "[LAW]",
            autocompletion=controllers,
        ),
    ] = None,
    *,
    out: Annotated[Path | None, option("LAW: write the certificate to this file.", "-o", "--out", "FILE")] = None,
    verify: Annotated[Path | None, option("Check a certificate's file again, without the solver.", "FILE")] = None,
    quick: Annotated[bool, option("LAW: try one small region only.")] = False,
    scenario: Annotated[
        str | None,
        option("LAW of a team: the scenario whose radio and timing count.", "NAME|FILE", autocompletion=scenarios),
    ] = None,
    assumed: Annotated[
        "LoopModel",
        FieldOptions(
            "robotics.plugins.certificates.loopmodel:LoopModel",
            *("curvature", "v_rate", "w_rate", "latency", "position_noise", "heading_noise"),
            of="LAW",
        ),
    ],
    law: Annotated[
        str, option("lyapunov, or pdc: parallel compensation, whose own options are the next three.")
    ] = "lyapunov",
    rule_base: Annotated[str, option("pdc: the rule base whose sets of distance and alpha it uses.")] = ("tracking"),
    distance: Annotated[tuple[float, float], option("pdc: range of the rules' distances, m.", "LOW HIGH")] = _DISTANCES,
    alpha: Annotated[float, option("pdc: bound of the rules' |alpha|, rad.")] = 0.5,
    gains: Annotated[
        "Lyapunov",
        FieldOptions(
            "robotics.laws.tracking.lyapunov:Lyapunov",
            *("kx", "ky", "kpsi", "form", "catch_up"),
            kx=Shown(doc="Gain K_x, 1/s."),
            ky=Shown(doc="Gain K_y, 1/m²."),
            kpsi=Shown(doc="Gain K_ψ, 1/m; with --form 2.31 in 1/s."),
            form=Shown(doc="Form of the law for ω: equation 2.31 or 2.32."),
            catch_up=Shown(doc="The law's catch_up, m/s; with 0 ω is exactly as printed."),
        ),
    ],
    speed: Annotated[tuple[float, float], option("Range of v_r, m/s.", "LOW HIGH")] = (0.2, 0.4),
    bounds: Annotated[
        "SectorModel",
        FieldOptions("robotics.plugins.certificates.certificate:SectorModel", "reference_turn", "turn", "heading"),
    ],
    decay: Annotated[
        float | None, option("Wanted decay rate, 1/s. A lower one gives a larger region. Default: the greatest")
    ] = None,
    robot: Annotated[
        str, option("The robot whose limits count: a name, or a .toml file.", "NAME|FILE", autocompletion=robots)
    ] = "etsro",
    seed: Annotated[int, option("Seed of the simulated starts and references.", min=0)] = 0,
    plot: Annotated[
        Path | None, option("Draw the region: .png, .pdf, .svg; of a LAW beside simulated starts.", "PICTURE")
    ] = None,
    json: Json = False,
) -> None:
    """Certify the stability of the Lyapunov law, decay rate and region, or of parallel compensation, decay rate.

    Both use linear matrix inequalities. For a LAW that corrects its reference, such as a rule base of dv and bend, it
    certifies a region of the sampled loop with its wheels, over boxes; another program checks its file again. For
    virtual structure, it certifies how fast the path parameters of a team agree over a radio that is late and lossy.

    \b
    Example:
      robotics certify --speed 0.2 0.4 --turn 3.5 --plot region.png
      robotics certify fuzzy-correcting:smooth=0 --speed 0.3 0.32 --curvature 0.2 --out loop.json --plot loop.png
      robotics certify --verify loop.json
      robotics certify virtual-structure-virtual:gamma=0 --scenario outage-10s
    """
    if verify is not None:
        _verify(verify, json)
        return
    if loop is not None and scenario is not None:
        _certify_team(loop, scenario, json)
        return
    if loop is not None:
        assumed = replace(assumed, speed_low=min(speed), speed_high=max(speed))
        _certify_loop(loop, assumed, robot, quick, out, plot, seed, json)
        return
    from robotics.plugins.certificates import certificate as theory
    from robotics.simulation.scenario.robots import load_robot

    if law not in ("lyapunov", "pdc"):
        raise theory.CertificateError(f"--law must be lyapunov or pdc; got {law!r}")
    if law == "pdc":
        if plot is not None:
            raise theory.CertificateError("--plot draws the region of --law lyapunov; of pdc no region is certified")
        _certify_compensation(rule_base, distance, alpha, json)
        return
    check_plot(plot)
    if speed[0] > speed[1]:
        raise theory.CertificateError(f"--speed: LOW must be at most HIGH; got {speed[0]:g} and {speed[1]:g} m/s")
    machine = load_robot(robot)
    model = replace(bounds, law=gains, speed_low=speed[0], speed_high=speed[1])
    found = theory.certify(model, decay)
    grid = model.grid(21)
    worst, trial = theory.worst_eigenvalue(grid, found.P), theory.try_out(found, seed=seed)
    if plot is not None:
        from fuzzy.figures.drawing import save_figure
        from robotics.plugins.certificates.figures import plot_certificate

        save_figure(plot_certificate(found, machine.robot, seed=seed), plot)
    x, y, psi = (float(width) for width in found.half_widths)
    report: dict[str, Any] = {
        "law": {name: getattr(gains, name) for name in ("kx", "ky", "kpsi", "form", "catch_up")},
        "premises": {"speed": speed, **{name: getattr(model, name) for name in ("reference_turn", "turn", "heading")}},
        **{name: getattr(found, name) for name in ("decay", "fastest", "P")},
        "region": {"x": x, "y": y, "heading": psi},
        "largest_turn": found.largest_turn,
        "largest_speed": found.largest_speed,
        "unsaturated_share": found.unsaturated(machine.robot),
        "worst_eigenvalue": found.worst_eigenvalue,
        "worst_eigenvalue_on_grid": worst,
        "grid": len(grid),
        "steps": trial.steps,
        "increases": trial.increases,
        "slowest_step": trial.slowest,
        "certified": _TEXTS.texts("certified.region", found=found, model=model, rate=rate(found.decay)),
        "not_certified": not_certified(found, machine),
    }
    if json:
        print_json(report)
        return
    print(f"law:    v = v_r cos ψ + {gains.kx:g} x,  {turning(model)}")
    print(f"decay:  {rate(found.decay)} 1/s (the greatest of any common P: {rate(found.fastest)})")
    print(f"region: e'Pe <= 1, reaching to x ±{x:.3g} m, y ±{y:.3g} m, ψ ±{psi:.3g} rad")
    corners = len(model.vertices())
    checked = _TEXTS.text(
        "checked.region", worst=worst, grid=len(grid), found=found, corners=corners, trial=trial, seed=seed
    )
    _print_proof(found.P, checked, report)


def _print_proof(p: "np.ndarray", checked: str, report: Mapping[str, Any]) -> None:
    """Print the matrix P, what was checked of it, and what it certifies."""
    print("P:      " + "\n        ".join("".join(f"{value:11.5g}" for value in row) for row in p))
    print(f"\nChecked\n- {checked}")
    _print_claims(report)


def _print_claims(report: Mapping[str, Any]) -> None:
    """Print what is certified and what is not."""
    for title, sentences in (("Certified", report["certified"]), ("Not certified", report["not_certified"])):
        print(f"\n{title}\n" + "\n".join(f"- {sentence}" for sentence in sentences))


def _verify(path: Path, json: bool) -> None:
    from fuzzy.errors import InputError
    from robotics.plugins.certificates.checker import RefutedError
    from robotics.plugins.certificates.checkfile import check

    try:
        data = check(path.read_bytes())
    except OSError:
        raise InputError(f"--verify {path}: there is no such file; give one that --out wrote") from None
    except RefutedError as error:
        raise InputError(f"{path}: refuted: {error}") from None
    if json:
        print_json({"holds": True, "law": data["law"], "V": data["V"], "loop": data["loop"]})
    else:
        print(f"{path}: the certificate of {data['law']} holds; it was checked without the search")


def _certify_loop(
    law: str,
    assumed: "LoopModel",
    robot: str,
    quick: bool,
    out: Path | None,
    plot: Path | None,
    seed: int,
    json: bool,
) -> None:
    from fuzzy.files.atomic import check_target
    from robotics.plugins.certificates.certificate import CertificateError
    from robotics.plugins.certificates.certificatefile import contents, write_certificate
    from robotics.plugins.certificates.commandstates import certified
    from robotics.plugins.certificates.loopmodel import closed_loop
    from robotics.plugins.certificates.regions import FULL_EFFORT, QUICK_EFFORT
    from robotics.plugins.certificates.starts import wheels_in_region
    from robotics.simulation.scenario.robots import load_robot

    check_target(out, ".json")
    check_plot(plot)
    machine = load_robot(robot).robot
    loop = closed_loop(law, machine, assumed)
    found, why = certified(loop, QUICK_EFFORT if quick else FULL_EFFORT)
    if found is None:
        raise CertificateError(f"{law}: not certified: {why}")
    if wrong := wheels_in_region(found, machine):
        raise CertificateError(f"{law}: not certified: {wrong}")
    if out is not None:
        write_certificate(found, out)
    if plot is not None:
        from fuzzy.figures.drawing import save_figure
        from robotics.plugins.certificates.badge import LoopBadge
        from robotics.plugins.certificates.basins import plot_basins, sampled_basin

        told = LoopBadge(found, "")
        save_figure(plot_basins([sampled_basin(law, machine, assumed, told=told, seed=seed)]), plot)
    (x, y, heading), end = map(float, found.half_widths()), found.half_widths(found.ultimate)
    before = "as its reference does before" if found.from_reference else "at the speeds that the law asks for there"
    about = {
        "model": loop.model,
        "inner": end,
        "rate": rate(found.rate),
        "before": before,
        "all": found.half_widths(1.0),
    }
    kind = "certified.states" if found.from_reference else "certified.loop"
    report: dict[str, Any] = {
        "law": law,
        "region": {"x": x, "y": y, "heading": heading},
        "ultimate": dict(zip(("x", "y", "heading"), map(float, end), strict=True)),
        "rate": found.rate,
        "P": found.P,
        **(V if isinstance(V := contents(found)["V"], dict) else {"V": V}),
        "wheels": {name: getattr(loop.wheels, name) for name in ("weights", "error", "reversal", "ripple")},
        "boxes": found.boxes,
        "certified": _TEXTS.texts(kind, **about),
        "not_certified": (*broken(machine), *_TEXTS.texts("not-certified.loop", **about)),
    }
    if json:
        print_json(report)
        return
    print(f"law:    {law}")
    print(f"region: z'Pz <= {found.region:.4g}, reaching to X ±{x:.3g} m, Y ±{y:.3g} m, ψ ±{heading:.3g} rad")
    _print_proof(found.P, f"V over {found.boxes:,} boxes, in intervals that are rounded outwards.", report)


def _certify_team(law: str, name: str, json: bool) -> None:
    from robotics.laws.catalogue import make_controller
    from robotics.laws.teams.virtual_structure import VirtualStructure
    from robotics.plugins.certificates.certificate import CertificateError
    from robotics.plugins.certificates.teams import certify_team
    from robotics.simulation.scenario.reading import load_scenario

    made = make_controller(law)
    if not isinstance(made, VirtualStructure):
        raise CertificateError(f"{law}: with --scenario the law of a team is certified, which is virtual structure")
    found = certify_team(made, load_scenario(name).setting)
    shown = "any delay" if math.isinf(found.allowed) else f"{found.allowed:.3g} s"
    about = {"found": found, "rate": rate(found.rate), "scenario": name, "shown": shown}
    report = {
        "law": law,
        "scenario": name,
        **{key: getattr(found, key) for key in ("rate", "end", "delay", "allowed")},
        "certified": _TEXTS.texts("certified.team", **about),
        "not_certified": _TEXTS.texts("not-certified.team", **about),
    }
    if json:
        print_json(report)
        return
    print(f"law:    {law}\nradio:  of {name}; a message is at most {found.delay:.3g} s old, proven up to {shown}")
    print(f"rate:   {rate(found.rate)} 1/s")
    _print_claims(report)


def _certify_compensation(rule_base: str, distance: tuple[float, float], alpha: float, json: bool) -> None:
    from robotics.laws.tracking.pdc import ParallelCompensation
    from robotics.plugins.certificates.certificate import CertificateError
    from robotics.plugins.certificates.compensation import certify_compensation

    law = ParallelCompensation(rule_base=rule_base)
    found = certify_compensation(law, *distance, alpha)
    rules, pairs = len(found.points), len(found.pairs)
    if found.P is None:
        raise CertificateError(
            f"no common P was found for these {rules} rules and the {pairs} pairs of them that fire together, though "
            f"each pair alone has its poles left of {found.slowest_pole:.3g} 1/s; give a lower --alpha, or a narrower "
            "--distance"
        )
    about = {"all": law.distances.size * law.alphas.size, "rules": rules, "alpha": alpha, "distance": distance}
    about["rate"] = rate(found.decay)
    report = {
        "law": {"rule_base": rule_base, "look_ahead": law.look_ahead},
        "rules": [
            {"distance": d, "alpha": a, "A": A, "B": B, "K": K}
            for (d, a), A, B, K in zip(found.points.tolist(), found.A, found.B, found.K, strict=True)
        ],
        "pairs": pairs,
        **{name: getattr(found, name) for name in ("P", "decay", "slowest_pole", "worst_eigenvalue")},
        "certified": _TEXTS.texts("certified.rules", **about),
        "not_certified": _TEXTS.texts("not-certified.rules"),
    }
    if json:
        print_json(report)
        return
    print("law:    (v, ω) = (v_r, ω_r) − Σ h_j K^j (X − X_d),  X = (d, α, ψ)\n")
    print("   d [m]  α [rad]   K^j: v by d, α, ψ          ω by d, α, ψ")
    for (d, a), K in zip(found.points, found.K, strict=True):
        print(f"{d:8.3g} {a:8.3g}" + "".join(f"{round(value, 3) + 0.0:9.3f}" for value in K.ravel()))
    print(f"\ndecay:  {rate(found.decay)} 1/s, common to {pairs} pairs of {rules} rules")
    checked = _TEXTS.text("checked.rules", found=found)
    _print_proof(found.P, checked, report)


def rate(value: float) -> str:
    """A certified rate with four digits, rounded down."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 3)
    return f"{math.floor(value / digit * (1 + 1e-12)) * digit:.4g}"


def turning(model: "SectorModel") -> str:
    """The law's formula for ω."""
    law = model.law
    if law.form == "2.31":
        return f"ω = ω_r + v_r {law.ky:g} y + {law.kpsi:g} sin ψ"
    speed = f"max(v_r, min(|v|, {law.catch_up:g}))" if law.catch_up > model.speed_low else "v_r"
    return f"ω = ω_r + {speed} ({law.ky:g} y + {law.kpsi:g} sin ψ)"


def not_certified(found: "Certificate", machine: "RobotModel") -> tuple[str, ...]:
    """The sentences that say what the certificate does not certify, for the limits of a robot."""
    share, name = found.unsaturated(machine.robot), machine.title.partition(":")[0] or machine.name
    how = "never" if share >= 1 else "sometimes" if share > 0 else "always"
    limits = _TEXTS.text(f"saturation.{how}", found=found, name=name, percent=100 * share)
    differs = _TEXTS.table("form")[found.model.law.form].format(model=found.model)
    said = _TEXTS.texts("not-certified.region", model=found.model, limits=limits, differs=differs)
    return (*broken(machine.robot), *said)


def broken(robot: "Robot") -> tuple[str, ...]:
    """A sentence where a robot has what no proof assumes: slip, a castor's drag, a dead band, rounded commands."""
    has = {name: f"{name} {shown(value)}" for name, value in robot.imperfections.items()}
    return _TEXTS.texts("not-certified.imperfect", has=listed([*has.values()])) if has else ()
