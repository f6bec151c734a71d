//! The hierarchical quadratic program: problem, solution, cascade
