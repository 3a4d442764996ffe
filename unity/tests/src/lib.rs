//! Nothing: the tests are in `tests`, and this makes a place for the program that they ship.
