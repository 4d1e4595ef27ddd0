"""Write every measured number of docs/model.md: figures and fits of new walks, speed from the benchmarks.

``python docs/write_model_page.py`` measures (three minutes), keeps the figures in docs/outputs/model.json
and writes the page; ``--page`` writes it from the kept figures, ``--check`` compares it with them. Speed is
kept by ``python -m benchmarks model legs parallel``, on a computer that does nothing else.
"""

import contextlib
import io
import json
import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PAGE, KEPT = ROOT / "docs" / "model.md", ROOT / "docs" / "outputs" / "model.json"
SPEED = ROOT / "docs" / "figures" / "model_benchmark.json"
BEGIN, END = "<!-- made: {} -->", "<!-- end: {} -->"
GAITS = ("tripod", "metachronal")
FITTED_CYCLES = "6"
SHOWN_PARAMETERS = 5


def measure() -> dict[str, Any]:
    """Draw all figures from new walks, fit to longer ones, and return what the page needs."""
    from robot.config.robot_file import load_robot
    from robot.study.figure_catalog import CATALOG, Material
    from robot.study.walk_errors import component_errors

    found: dict[str, Any] = {"walks": {}, "sensitivity": {}}
    material = Material(load_robot(), 3.0, 0, {}, SPEED, lambda _: None)
    found["captions"] = {
        one.name: one.draw(material).caption
        for one in CATALOG
        if one.name not in {"runtime", "parallel"}
    }
    for gait in GAITS:
        walk = material.walk(gait)
        paths = (walk.position_W, walk.viscous.pose, walk.coulomb.pose)
        found["walks"][gait] = {
            "distance_m": [float(sum((p[-1, :2] - p[0, :2]) ** 2) ** 0.5) for p in paths],
            "errors": {
                row.component: [row.spread, row.viscous, row.coulomb, row.apart]
                for row in component_errors(walk).values()
            },
        }
        log = f"runs/docs/six_{gait}.mcap"
        (ROOT / log).unlink(missing_ok=True)
        printed("drive", "--gait", gait, "--cycles", FITTED_CYCLES, "--virtual-time", "--log", log)
        found["sensitivity"][gait] = json.loads(printed("model", "sensitivity", log, "--json"))
    found["fit"] = printed("model", "sensitivity", "runs/docs/six_tripod.mcap").splitlines()
    return found


def printed(*words: str) -> str:
    """Return what a command prints."""
    from robot.cli import main as cli

    print("bigant", *words, flush=True)
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        code = cli.run(list(words))
    if code:
        sys.exit(f"ended with {code}: {out.getvalue()}")
    return out.getvalue()


def pieces(found: dict[str, Any], speed: dict[str, Any]) -> dict[str, str]:
    """Return what stands between each pair of marks."""
    return {
        "speed": speed_table(speed),
        "fit": fit_block(found),
        "fit words": fit_words(found),
        "figures": figures_table(found, speed),
        "sway": sway_words(found),
    }


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Return a table in Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def short(value: float) -> str:
    """Write a time in microseconds with two digits at least."""
    return f"{value:.0f}" if value >= 20 else f"{value:.2g}"


def ribbon(one: dict[str, float]) -> str:
    """Write a median with its quartiles."""
    return f"{short(one['median'])} ({short(one['q25'])}, {short(one['q75'])})"


def legs_row(columns: dict[str, list[float]], legs: list[int]) -> str:
    """Write medians over numbers of legs, and how much the most cost."""
    medians = columns["median"]
    return (
        f"{' / '.join(map(short, medians))}: {legs[-1]} legs cost {medians[-1] / medians[0]:.1f} times "
        f"{legs[0]}"
    )


def speed_table(speed: dict[str, Any]) -> str:
    """The table of run times."""
    model, legs = speed["model"], speed["legs"]
    counts = " / ".join(map(str, legs))
    faster = model["coulomb_reference"]["median"] / model["coulomb"]["median"]
    against = speed["mujoco_us"]["median"][-1] / speed["ours_us"]["median"][-1]
    sums, product = model["sums"]["median"], model["product"]["median"]
    pairs = [
        f"{law} {speed[key]['median'][-1]:.2f} ({speed[key]['q25'][-1]:.2f}, {speed[key]['q75'][-1]:.2f})"
        for law, key in (("viscous", "overhead"), ("Coulomb", "overhead_coulomb"))
    ]
    return table(("what", "ours", "stated in the paper"), [
        ("viscous-Coulomb, hexapod, 20,000 frames at once", ribbon(model["viscous"]), ""),
        ("the same, one call from Python with its result types", ribbon(model["single"]), "190 (180, 240)"),
        ("the same in plain numpy", ribbon(model["numpy"]), ""),
        ("Coulomb to convergence, 20,000 at once", ribbon(model["coulomb"]), "10,400 (3250, 15,000)"),
        ("Coulomb by the paper's method, same run",
         f"{ribbon(model['coulomb_reference'])}, {faster:.0f} times slower than ours", ""),
        (f"{counts} legs, viscous, 1000 poses", legs_row(speed["ours_us"], legs), "less than 3 times"),
        (f"{counts} legs, Coulomb", legs_row(speed["coulomb_us"], legs), ""),
        ("MuJoCo `mj_step` of the same disk",
         f"{legs_row(speed['mujoco_us'], legs)}; {against:.0f} times ours", "13 times"),
        ("trajectory of 10,000 steps: running sums, linear pass",
         f"{sums:.0f}, {product:.0f}: {product / sums:.0f} times", ""),
        ("two processes, 300,000 frames: time x 2 / time on one", ", ".join(pairs), "below 1.5 at four"),
    ])  # fmt: skip


def fit_block(found: dict[str, Any]) -> str:
    """What ``bigant model sensitivity`` prints, shortened."""
    lines: list[str] = found["fit"]
    first = next(i for i, line in enumerate(lines) if line.startswith("naive:"))
    parameters = next(i for i, line in enumerate(lines) if line.startswith("fitted parameters"))
    rows = next(i for i, line in enumerate(lines) if line.startswith("change:"))
    shown = [*lines[first:rows], "...", *lines[parameters : parameters + 1 + SHOWN_PARAMETERS]]
    return "\n".join(["```", *shown, "```"])


def fit_words(found: dict[str, Any]) -> str:
    """What the fits of both gaits say, in a sentence each."""
    tripod, metachronal = (found["sensitivity"][gait] for gait in GAITS)
    stiffness = [one["value"] for one in tripod["stiffness"]["parameters"]]
    worst = max(abs(value / 2500 - 1) for value in stiffness)
    naive = 2500 / (10 * tripod["fitted_to"]["weight_n"])
    heading = metachronal["rmse"][0]["change_percent"]
    mu = [
        one["value"]
        for one in metachronal["friction"]["parameters"]
        if one["name"].startswith("mu ")
    ]
    worse = "worse" if heading < 0 else "better"
    return (
        f"K is recovered within {100 * worst:.1f} %. Most of the naive parameters' error comes from "
        f"their stiffness, {naive:.1f} times\ntoo low for this robot; the small changes that the paper "
        "found do not appear here. For the metachronal\ngait, fitting the *viscous* law makes "
        f"heading {worse} on held-out frames ({heading:+.1f} % from fitted to naive), and the\n"
        f"fitted mu range from {min(mu):.1f} to {max(mu):.1f}: there the law is wrong, not its parameters."
    )


def figures_table(found: dict[str, Any], speed: dict[str, Any]) -> str:
    """The paper's statements, ours next to them."""
    captions = found["captions"]

    def ours(name: str) -> str:
        return barless(captions[name].partition(" The paper ")[0])

    tripod, metachronal = (found["walks"][gait] for gait in GAITS)
    true, viscous, coulomb = metachronal["distance_m"]
    step = re.search(r"\(B\) (.*?), a step", captions["metachronal"])
    slip = re.search(r"ours \(([-\d.]+), ([-\d.]+)\)", captions["metachronal"])
    assert step is not None
    assert slip is not None
    legs = speed["legs"]
    return table(("the paper", "ours"), [
        ("1-D: Coulomb is the median (any speed between the middle two for an even number), "
         "viscous the mean", ours("line")),
        ("2-D contours: a smooth bowl against point discontinuities, nearly the same balance",
         ours("force-field")),
        ('"within 2 % of Coulomb for abs(dv) < 0.2 abs(v)"',
         f"{barless(captions['friction-error'])} See erratum E9."),
        ("tripod: the two laws are closer to each other than to the robot",
         f"{alike(tripod, 'vx', 'mm/s')}; {alike(tripod, 'yaw rate', 'mrad/s')}"),
        ("metachronal: forces show Coulomb's step",
         f"{barless(step[1])}, mu being 0.6; the viscous law walks {100 * (viscous / true - 1):.0f} % "
         f"too far, Coulomb's {100 * (coulomb / true - 1):+.1f} %"),
        ("metachronal slip, 5 to 95 %: -51.8 to 111.8 mm/s",
         f"{slip[1]} to {slip[2]} mm/s: our legs' dimensions are assumed, the paper gives none"),
        ("run time less than 3 times from 3 to 50 legs, parallel overhead below 1.5",
         f"{legs[-1]} legs cost {speed['ours_us']['median'][-1] / speed['ours_us']['median'][0]:.1f} times "
         f"{legs[0]}, overhead {speed['overhead']['median'][-1]:.2f} on two processes; "
         "a figure shows the contact search"),
    ])  # fmt: skip


def barless(text: str) -> str:
    """Write absolute values in words: a bar would end the cell of a table."""
    return re.sub(r"\|([^|]+)\|", r"abs(\1)", text)


def alike(walk: dict[str, Any], component: str, unit: str) -> str:
    """Whether the laws are closer to each other than to the truth, in one component."""
    _, viscous, coulomb, apart = walk["errors"][component]
    holds = "true" if apart < min(viscous, coulomb) else "not true"
    return (
        f"{holds} for {component}: laws {apart:.1f} {unit} apart, RMSE {viscous:.1f} (viscous) and "
        f"{coulomb:.1f} {unit} (Coulomb)"
    )


def sway_words(found: dict[str, Any]) -> str:
    """What adding the sway does to the tripod's velocity error."""
    errors = found["walks"]["tripod"]["errors"]
    return (
        f"Adding it cuts the tripod's RMSE of vy from {errors['vy'][2]:.2f} to "
        f"{errors['vy + sway'][2]:.2f} mm/s, of vx from {errors['vx'][2]:.2f} to "
        f"{errors['vx + sway'][2]:.2f} mm/s\n(Coulomb's law)."
    )


def filled(page: str, made: dict[str, str]) -> str:
    """Return the page with each piece between its marks."""
    for name, text in made.items():
        head, rest = page.split(BEGIN.format(name))
        _, tail = rest.split(END.format(name))
        page = f"{head}{BEGIN.format(name)}\n{text}\n{END.format(name)}{tail}"
    return page


def main() -> None:
    """Measure unless an option says not to, and write or compare the page."""
    if not {"--check", "--page"} & set(sys.argv):
        KEPT.write_text(json.dumps(measure(), indent=1) + "\n", encoding="utf-8")
    found, speed = (json.loads(path.read_text(encoding="utf-8")) for path in (KEPT, SPEED))
    page = PAGE.read_text(encoding="utf-8")
    made = filled(page, pieces(found, speed))
    if "--check" not in sys.argv:
        PAGE.write_text(made, encoding="utf-8")
    elif made != page:
        sys.exit(f"{PAGE.name} is not what {KEPT.name} says; run: make docs-assets")
    print(f"{PAGE.name} is what {KEPT.name} and {SPEED.name} say")


if __name__ == "__main__":
    main()
