"""The robot as a program: from the robot file to the command line.

Rooms from top to bottom: cli, campaign, gap_report, replay | odometry | study | bringup, virtual, view,
report, run, control, design, config, console. A room imports only those below it; import-linter holds it to
that.
"""
