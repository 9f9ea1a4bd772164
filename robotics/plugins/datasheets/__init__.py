"""What a robot is, drawn and in numbers: the command ``robotics robot``."""
