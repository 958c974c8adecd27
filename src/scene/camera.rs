//! The camera of a scene.

use crate::camera::{Camera, CameraError};
use crate::error::Error;
use crate::scene_file::Description;

/// Makes the camera of a scene.
///
/// # Errors
/// [`Error::Source`] for a camera that sees nothing.
pub(super) fn camera(description: &Description) -> Result<Camera, Error> {
    let block = &description.camera;
    let angle_radians = block.angle_degrees.value.to_radians();
    let camera = Camera::new(block.center.value, block.direction.value, block.up.value, angle_radians);
    camera.map_err(|error| {
        let (span, message) = match error {
            CameraError::Angle => (block.angle_degrees.span, "'angle' must be above 0 and below 180 degrees"),
            CameraError::Direction => (block.direction.span, "'direction' has no length"),
            CameraError::Up => (block.up.span, "'up' has no length"),
            CameraError::UpAlongDirection => (block.up.span, "'up' is parallel to 'direction'"),
        };
        description.source.error(span, message)
    })
}
