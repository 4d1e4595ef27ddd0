"""Examples of every command, as its help shows them; a test parses each of them."""

from collections.abc import Mapping

EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "drive": (
        "bigant drive --gait tripod --cycles 3",
        "bigant drive --teleop",
        "bigant drive --hardware /dev/ttyUSB0 --armed --log runs/first.mcap",
    ),
    "show": (
        "bigant show runs/first_walk.mcap",
        "bigant show runs/first_walk.mcap --video walk.mp4 --speed 2",
        "bigant show runs/first_walk.mcap --json",
    ),
    "report": (
        "bigant report runs",
        "bigant report runs/today --reference runs/yesterday --pages",
    ),
    "devices": (
        "bigant devices",
        "bigant devices --port /dev/ttyUSB0 --discover none --json",
    ),
    "model run": (
        "bigant model run bigant --gait metachronal --law both",
        "bigant model run multipod --legs 10 --out multipod.png",
    ),
    "model sensitivity": ("bigant model sensitivity runs/first_walk.mcap --json",),
    "model figures": (
        "bigant model figures --list",
        "bigant model figures --out figures",
    ),
    "replay": (
        "bigant replay runs/first_walk.mcap",
        "bigant replay runs/first_walk.mcap --drive --virtual-time",
    ),
    "log info": ("bigant log info runs/first_walk.mcap --json",),
    "log repair": ("bigant log repair runs/cut.mcap --out runs/repaired.mcap",),
    "log trim": ("bigant log trim runs/first_walk.mcap --from 10 --to 20 --out piece.mcap",),
    "log merge": ("bigant log merge morning.mcap noon.mcap --out day.mcap",),
    "log export": (
        "bigant log export runs/first_walk.mcap --format trial",
        "bigant log export runs/first_walk.mcap --format csv --what joints,forces",
    ),
    "odom": (
        "bigant odom runs/first_walk.mcap --compare",
        "bigant odom runs/first_walk.mcap --out first_walk.tum",
    ),
    "gap demo": (
        "bigant gap demo",
        "bigant gap demo --effect foot_friction@ML:ratio=0.6 --out runs/slippery",
    ),
    "gap diagnose": (
        "bigant gap diagnose today-1.mcap today-2.mcap --reference healthy-1.mcap healthy-2.mcap",
        "bigant gap diagnose walk.toml --json walk.json --html walk.html",
        "bigant gap diagnose arm/*.parquet --joint Elbow",
        "bigant gap diagnose --alone arm/*.parquet --joint Elbow --effect command_delay+play",
    ),
    "campaign score": (
        "bigant campaign score dev --scenario scenario.toml --markdown figures.md",
        "bigant campaign score final --key final.key --removed 15 --json final.json",
        "bigant campaign score realities --realities --markdown figures.md",
    ),
    "gap apply": ("bigant gap apply walk.json --out corrected.toml",),
    "gap next": ("bigant gap next walk.json", "bigant gap next trial_1.parquet --json"),
    "gap effects": ("bigant gap effects --stage friction", "bigant gap effects --json"),
    "robot show": (
        "bigant robot show",
        "bigant robot show examples/octopod.toml --gait metachronal --out octopod.html",
    ),
    "robot new": (
        "bigant robot new --name Lab --out lab.toml",
        "bigant robot new --name Rollo --legs 6 --leg crank --servo XL430-W250 --out rollo.toml",
    ),
    "robot export": ("bigant robot export --urdf bigant.urdf --mjcf bigant.xml",),
    "sim effects": ("bigant sim effects", "bigant sim effects --json"),
    "sim realities": ("bigant sim realities", "bigant sim realities --json"),
    "sim run": (
        "bigant sim run --gait tripod --effect foot_friction@ML:ratio=0.5 --fast --out a.parquet",
        "bigant sim run --gait tripod --effect com_offset:x_m=0.03 --out a.mcap",
    ),
    "campaign make": (
        "bigant campaign make scenario.toml --jobs 2 --out dev",
        "bigant campaign make scenario.toml --out final --sealed --key final.key",
    ),
    "campaign unseal": ("bigant campaign unseal final --key final.key --out labels.json",),
    "sim render": ("bigant sim render a.parquet --out a.gif",),
    "import": (
        "bigant import table.csv --map map.toml --out walk.mcap",
        "bigant import --maps",
        "bigant import so101_servo_arm/*.npz --map so101 --out arm",
    ),
    "servo setup": (
        "bigant servo setup --port /dev/ttyUSB0",
        "bigant servo setup --port /dev/ttyUSB0 --id 1 --new-id 4",
    ),
    "servo backup": ("bigant servo backup --port /dev/ttyUSB0 --out servos.toml",),
    "servo restore": ("bigant servo restore --port /dev/ttyUSB0 servos.toml",),
    "servo zero": ("bigant servo zero --port /dev/ttyUSB0 --write lab.toml",),
    "servo watch": ("bigant servo watch --port /dev/ttyUSB0 --seconds 10",),
    "servo reboot": ("bigant servo reboot --port /dev/ttyUSB0 --id 3",),
    "servo jog": (
        "bigant servo jog --leg FL --deg 10",
        "bigant servo jog --hardware /dev/ttyUSB0 --leg FL --deg 10 --armed",
    ),
    "bringup": (
        "bigant bringup --folder bringup",
        "bigant bringup --hardware /dev/ttyUSB0 --armed --folder bringup",
        "bigant bringup --hardware /dev/ttyUSB0 --folder bringup --only 11",
    ),
    "check": (
        "bigant check",
        "bigant check --computer",
        "bigant check --hardware /dev/ttyUSB0 --loop",
        "bigant check --hardware /dev/ttyUSB0 --armed --json",
    ),
    "view": (
        "bigant view --live",
        "bigant view --live --browser",
        "bigant view --live --terminal",
        "bigant view runs/first_walk.mcap --save walk.rrd",
        "bigant view runs/first_walk.mcap --ros2 --speed 2 --prefix lab1",
        "bigant view runs/first_walk.mcap --save walk-view.mcap --layout layout.json",
    ),
    "examples": ("bigant examples", "bigant examples octopod.toml --out lab"),
    "completion": (
        "bigant completion bash > ~/.local/share/bash-completion/completions/bigant",
        "bigant completion fish > ~/.config/fish/completions/bigant.fish",
    ),
    "sim serve": ("bigant sim serve", "bigant sim serve --scenario examples/faults_servo.toml"),
    "sim faults": ("bigant sim faults", "bigant sim faults --json"),
    "force watch": ("bigant force watch",),
    "force bias": ("bigant force bias",),
    "force identify": (
        "bigant force identify --hardware virtual",
        "bigant force identify --leg FL",
    ),
    "force calibrate": ("bigant force calibrate",),
}
