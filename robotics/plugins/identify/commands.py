"""The commands ``robotics identify`` and ``robotics excite``: a robot's numbers from a drive, and the drive for it."""

from pathlib import Path
from typing import Annotated

from fuzzy.commands.shared import check_plot
from fuzzy.files.atomic import check_target, write_whole
from fuzzy.shell.options import Json, argument, option
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown
from robotics.commands.completion import robots
from robotics.plugins.logs.runfiles import Distribution

Sheet = Annotated[
    str,
    option("The data sheet: a robot's name, or its file.", "--robot", "-r", "NAME|FILE.toml", autocompletion=robots),
]


def identify(
    log: Annotated[Path, argument("A rosbag2 folder, an .mcap, .db3, .bag or .csv file.", "LOG")],
    *,
    out: Annotated[Path | None, option("Write the robot's file.", "--out", "-o", "FILE.toml")] = None,
    robot: Sheet = "etsro",
    page: Annotated[Path | None, option("Write a page of fits, numbers and advice.", "FILE.html")] = None,
    plot: Annotated[Path | None, option("Draw the fits: .png, .pdf, .svg.", "PICTURE")] = None,
    namespace: Annotated[str, option("Whose drive, in a log of several: robot2.", "NAME")] = "",
    odom: Annotated[str, option("Odometry. Default: odom, or the only one.", "TOPIC")] = "",
    cmd_vel: Annotated[str, option("Commands. Default: cmd_vel, or the only one.", "TOPIC")] = "",
    pose: Annotated[str, option("Poses that do not come from the wheels. Default: odometry's.", "TOPIC")] = "",
    imu: Annotated[str, option("A gyroscope's sensor_msgs/Imu. Default: none.", "TOPIC")] = "",
    ros: Distribution = "jazzy",
    seed: Annotated[int, option("Seed of the starts of the fit.", min=0)] = 0,
    json: Json = False,
) -> None:
    """Identify a robot from a minute of driving: latency, lag, limits, friction, dead band, wheels and noise.

    Commands and measured velocities are enough; a pose that does not come from the wheels also tells radii and axle.
    Mass and size are the data sheet's. Every number has a 95 % interval, or a sentence that the log does not tell it.

    A CSV file has a header such as "time [s],v_command [m/s],w_command [rad/s],v [m/s],w [rad/s]", and may have the
    columns x, y, heading, yaw_rate, or wheel speeds right and left in place of v and w.

    \b
    Example:
      robotics excite --robot etsro -o excite.csv --drive drive.mcap
      robotics identify drive.mcap --robot etsro -o myrobot.toml --page fits.html
      robotics run fuzzy-off-path --robot myrobot.toml
    """
    from robotics.plugins.identify.identified import identify as identified
    from robotics.plugins.identify.robotfile import identified_text
    from robotics.plugins.identify.signals import read_signals
    from robotics.simulation.scenario.robots import load_robot

    check_target(out, ".toml")
    check_target(page, ".html")
    check_plot(plot)
    model = load_robot(robot)
    topics = {"odometry": odom, "commands": cmd_vel, "pose": pose, "imu": imu}
    found = identified(read_signals(log, model.robot, namespace, distribution=ros, **topics), model, seed)
    text = identified_text(found, robot)
    if out is not None:
        write_whole(out, text)
    if page is not None:
        from robotics.plugins.identify.figures import write_page

        write_page(found, page)
    if plot is not None:
        from fuzzy.figures.drawing import save_figure
        from robotics.plugins.identify.figures import plot_identified

        save_figure(plot_identified(found), plot)
    if json:
        print_json(
            {
                "log": str(log),
                "robot": robot,
                "numbers": [each.row() for each in found.numbers],
                "averaged": found.motion.averaged,
                "prediction_5s": found.prediction,
                "whiteness": [test.__dict__ for test in found.whiteness],
                "sentences": list(found.sentences),
                "advice": list(found.advice),
                "toml": text,
            }
        )
        return
    for each in found.numbers:
        sure = each.interval if each.known != "no" else f"{each.interval} (hardly known)"
        print(f"{each.name:<16} {shown(each.value):>10} {each.unit:<7} {sure:<28} {each.title}")
    said = found.prediction
    print(
        f"\nPredicted by commands alone: {shown(said['v'], digits=3)} m/s and {shown(said['w'], digits=3)} rad/s off, "
        f"after 5 s {shown(said['way'], digits=3)} m."
    )
    print(*found.sentences, sep="\n")
    if found.advice:
        print("\nTo learn more:", *found.advice, sep="\n  ")
    print(*(file for file in (out, page, plot) if file is not None), sep="\n")


def excite(
    *,
    robot: Sheet = "etsro",
    out: Annotated[Path, option("Write the commands: .csv or .mcap.", "--out", "-o", "FILE")],
    square: Annotated[float, option("Side of the square in whose middle the robot begins.", "M")] = 3.0,
    seconds: Annotated[float, option("How long the commands are.", "S")] = 60.0,
    drive: Annotated[
        Path | None, option("Simulate the robot on them, and write its log: .csv or .mcap.", "--drive", "FILE")
    ] = None,
    latency: Annotated[float, option("Latency of the simulated robot, in steps of 10 ms.", "S", min=0)] = 0.1,
    seed: Annotated[int, option("Seed of the robots that are drawn, and of the simulated noise.", min=0)] = 0,
    json: Json = False,
) -> None:
    """Write a minute of commands that tells most of a robot, and keeps it within a square.

    Slow ramps find the dead band; then come steps that lead back to where they began, chosen for what they tell
    (D-optimality). Robots drawn from a range around the data sheet, with wrong wheels and latencies up to 0.3 s, stay
    inside, with a margin. Keep people away, and a hand at the switch: a robot out of that range may leave the square.

    The columns are time [s], v_command [m/s] and w_command [rad/s], every 50 ms: publish each row at its time on the
    topic cmd_vel (geometry_msgs/TwistStamped), and log cmd_vel and odom. As .mcap, ros2 bag play publishes them.

    \b
    Example:
      robotics excite --robot turtlebot3-burger --square 3 --seconds 60 -o excite.csv
      robotics excite --robot etsro -o excite.csv --drive drive.mcap
      robotics identify drive.mcap --robot etsro -o myrobot.toml
    """
    from robotics.plugins.identify.excitation import excite as excitation
    from robotics.plugins.identify.replay import replayed, write_drive, write_program
    from robotics.simulation.scenario.robots import load_robot

    check_target(out, ".csv", ".mcap")
    check_target(drive, ".csv", ".mcap")
    model = load_robot(robot)
    found = excitation(model.robot, square, seconds, seed)
    write_program(found.program, out)
    if drive is not None:
        write_drive(replayed(model.robot, found.program, latency=latency, seed=seed), drive)
    if json:
        print_json(
            {
                "file": str(out),
                "topic": "cmd_vel",
                "manoeuvres": list(found.names),
                "efficiency": found.efficiency,
                "room_m": found.room,
            }
        )
        return
    print(f"{out}: {len(found.program.time)} commands in {seconds:g} s, for the topic cmd_vel at 20 Hz")
    print(*(f"  {name}" for name in found.names), sep="\n")
    print(
        f"It tells {shown(found.efficiency, digits=2)} times as much of each number as manoeuvres at random. Of "
        f"64 robots drawn, none comes nearer to the square's edge than {shown(found.room, digits=2)} m."
    )
    if drive is not None:
        print(drive)
