//! URDF to model, forward kinematics, Jacobians, shapes and distances
