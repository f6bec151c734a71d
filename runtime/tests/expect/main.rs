//! Expectations: a log judged as a whole and tick by tick, against the definitions, the laws of logic and rtamt.

mod brute;
mod cases;
mod generate;
mod laws;
mod rtamt;
