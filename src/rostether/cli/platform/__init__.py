"""The nodes of the sensing platform as roles, and `rostether sensor`."""
