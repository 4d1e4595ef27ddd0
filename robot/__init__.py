"""The controller: robot file, safety gate, pure step, loop and command line."""
