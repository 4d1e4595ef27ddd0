"""What half and twice of each constant of the diagnosis does to its figures."""
