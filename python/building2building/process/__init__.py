"""Processes: the command ``b2b``, temporary folders, and where pip put EnergyPlus."""
