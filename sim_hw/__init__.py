"""Virtual hardware: a plant, and virtual devices that speak the real bytes in front of it."""
