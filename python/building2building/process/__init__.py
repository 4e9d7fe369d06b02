"""Processes: temporary folders, and where pip put EnergyPlus."""
