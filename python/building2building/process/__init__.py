"""Temporary folders, and the folder where pip installed EnergyPlus."""
