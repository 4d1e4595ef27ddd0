"""Named systems as data: foot motion, contact and load of robots with slipping feet.

Each module builds one kind of robot as a ``System``; ``model.systems.predict`` runs any of them.
"""
