"""A robot that somebody else wrote: a hexapod in MuJoCo that judges ``bigant gap diagnose``.

``layout``, ``fault``, ``robot``, ``gait``, ``day``, ``servo``, ``feet``, ``sensors`` and ``run`` are the
simulator. They import nothing of ours outside this folder: a simulator that shared formulas with the
diagnosis could not judge it. ``cases`` says what is wrong in each case, ``table`` writes what a foreign
engineer would hand over, and ``answers`` and ``score`` are the only modules that use the product.
"""
