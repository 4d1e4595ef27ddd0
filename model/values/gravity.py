"""The acceleration of gravity.

Not scipy's: importing its table of constants takes an eighth of a second and 20 MB, for every command.
"""

STANDARD_GRAVITY = 9.80665  # m/s^2, by definition (3rd CGPM, 1901)
