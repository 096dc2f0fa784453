//! Declarations and a C shim of batched calls for SUMO's libsumo.
