//! Adaptive-network-based fuzzy inference systems (Jang 1993).
#![forbid(unsafe_code)]
