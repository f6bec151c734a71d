//! Names, types, units, checks and lowering of Hierarq specs to programs
