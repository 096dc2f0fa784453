//! What reports say of traffic signals beside what they say of any task: levels of service, what is overloaded, the
//! map, signal plans; and the page on the quality of a family that was derived from a map.

mod answers;
mod audit;
mod capacity;
mod corridors;
mod demand;
mod happened;
mod intersections;
pub mod level_of_service;
mod levels;
mod map;
mod map_view;
mod measures;
mod movements;
mod overloaded;
mod pages;
mod periods;
pub mod plans;
pub mod quality;
mod remarks;
mod savings;
mod sections;
mod shown;
mod sketch;

pub use measures::TrafficMeasures;
pub use overloaded::Overloaded;
pub use sections::TrafficSections;
