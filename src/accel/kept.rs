//! [`Kept`]: the arrays of a run of rays, which a thread keeps for its next run. Setting them to zero for every run costs
//! as much as finding what the rays hit.

use std::cell::Cell;

/// Stands in a `thread_local!`. Whoever takes it puts it back; who asks in between gets a new one.
pub type Kept<T> = Cell<Option<Box<T>>>;
