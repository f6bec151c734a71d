//! Compiled programs, the controller that runs them and the simulated robot
