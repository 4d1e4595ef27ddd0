"""The two devices on the robot: the Dynamixel bus and the ATI wireless force-torque stream."""
