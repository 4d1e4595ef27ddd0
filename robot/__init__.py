"""The robot as a program: from the robot file to the command line.

Packages from top to bottom: cli, campaign, gap_report, replay | odometry | study | bringup, virtual, view,
report, run, control, design, config, console. A package imports only those below it;
import-linter enforces that.
"""
