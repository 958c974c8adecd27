//! Small scenes in memory, the modes in which each case must hold, and the table of measured errors.

use a2::args::{self, Request};
use a2::film::Film;
use a2::memory::Budget;
use a2::objects::{Hit, PreparedRay, Ray, SurfaceHit, SurfacePoint, T_MAX, intersect_triangle};
use a2::plan::Plan;
use a2::ray_counts::RayCounts;
use a2::scene::{Compiled, Scene, compile};
use a2::scene_file;
use a2::simd::InstructionSet;
use a2::timing::Deadline;
use a2::trace::{Seen, trace_ray};
use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Mutex;
use vecmath::{Real, Vector3};

/// The unit roundoff u of `f64`. With the feature `f32` too, so that error bounds stay the same.
pub const U: f64 = f64::EPSILON / 2.0;

/// Flags and instruction set of a run.
#[derive(Clone, Copy, Debug)]
pub struct Mode {
    /// Added to the command line.
    pub flags: &'static str,
    pub instruction_set: InstructionSet,
}

impl Mode {
    pub fn robust(&self) -> bool {
        self.flags.contains("-robust")
    }
}

/// Returns all modes in which a case must hold: with and without `-robust`, and with every instruction set.
pub fn modes() -> impl Iterator<Item = Mode> {
    let mode = |flags| InstructionSet::available().map(move |instruction_set| Mode { flags, instruction_set });
    ["", "-robust"].into_iter().flat_map(mode)
}

/// Adds a case to the table with its error bound and measured error, and checks that the error is within the bound.
pub fn check(case: &str, bound: f64, measured: f64) {
    // A lock, because threads must write whole lines.
    static TABLE: Mutex<()> = Mutex::new(());
    if let Some(path) = std::env::var_os("A2_NUMERICS_TABLE") {
        let _guard = TABLE.lock();
        let mut file = std::fs::OpenOptions::new().create(true).append(true).open(path).unwrap();
        file.write_all(format!("{case}\t{bound:e}\t{measured:e}\n").as_bytes()).unwrap();
    }
    // The table of single precision needs all cases, also those that fail. Nothing turns the checks of `f64` off.
    if cfg!(not(feature = "f32")) || std::env::var_os("A2_NUMERICS_KEEP_GOING").is_none() {
        assert!(measured <= bound, "{case}: {measured:e} is over {bound:e}");
    }
}

/// Does the same for a statement that is true or false.
pub fn check_that(case: &str, holds: bool) {
    check(case, 0.0, f64::from(u8::from(!holds)));
}

/// A compiled scene with its plan and options.
pub struct Studio {
    pub scene: Scene,
    pub plan: Plan,
    pub warnings: Vec<String>,
    request: a2::options::Options,
}

pub fn vector(v: [f64; 3]) -> Vector3 {
    Vector3::from(v.map(|x| x as Real))
}

pub fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
    Ray { origin: vector(origin), direction: vector(direction) }
}

/// A camera, for cases that use rays of their own.
pub const CAMERA: &str = "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 30 }\n";

/// Makes the text of a scene of objects with one white material, seen by [`CAMERA`].
pub fn objects(objects: &str) -> String {
    let count = objects.matches("Sphere {").count()
        + objects.matches("Plane {").count()
        + objects.matches("Triangle {").count()
        + objects.matches("TriangleMesh {").count();
    let nested = objects.contains("Transform {");
    let count = if nested { objects.matches("Transform {").count() } else { count };
    format!(
        "{CAMERA}Materials {{ numMaterials 1 Material {{ }} }}\nGroup {{ numObjects {count} MaterialIndex 0\n{objects} }}\n"
    )
}

impl Studio {
    pub fn new(text: &str, flags: &str) -> Self {
        Self::with_meshes(text, &[], flags)
    }

    /// Compiles a scene with mesh files, given by name and content.
    pub fn with_meshes(text: &str, meshes: &[(&str, &str)], flags: &str) -> Self {
        Self::try_new(text, meshes, flags).unwrap_or_else(|message| panic!("{message}\n{text}"))
    }

    /// Returns the error message of a scene that must be refused.
    pub fn refusal(text: &str) -> String {
        match Self::try_new(text, &[], "") {
            Ok(_) => panic!("not refused: {text}"),
            Err(message) => message,
        }
    }

    fn try_new(text: &str, meshes: &[(&str, &str)], flags: &str) -> Result<Self, String> {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in meshes {
            std::fs::write(folder.path().join(name), content).unwrap();
        }
        let path = match meshes.is_empty() {
            true => PathBuf::from("s.txt"),
            false => folder.path().join("s.txt"),
        };
        let request = request(&format!("-input s.txt -output c.png -normals n.png -depth 0 1 d.png {flags}"));
        let source = a2::error::SourceText { path, text: text.to_owned() };
        let description = scene_file::parse(source).whole().map_err(|error| error.to_string())?;
        let plan = Plan::new(&request, &description);
        let Compiled { scene, remarks, .. } =
            compile(&description, &plan, &mut Budget::default()).map_err(|error| error.to_string())?;
        let warnings = [remarks.warnings, remarks.hints].concat();
        Ok(Self { scene, plan, warnings, request })
    }

    /// Returns the same scene with the instruction set of a mode.
    pub fn at(mut self, mode: Mode) -> Self {
        self.scene.geometry.instruction_set = mode.instruction_set;
        self
    }

    pub fn hit(&self, ray: &Ray) -> Option<Hit> {
        self.scene.geometry.closest_hit(ray)
    }

    pub fn t(&self, ray: &Ray) -> Option<f64> {
        self.hit(ray).map(|hit| f64::from(hit.surface.t))
    }

    /// Finds the closest hit by a loop over all objects and all triangles.
    pub fn hit_by_loop(&self, ray: &Ray) -> Option<Hit> {
        let prepared = PreparedRay::new(*ray);
        let mut closest: Option<Hit> = None;
        for (index, object) in self.scene.geometry.objects.iter().enumerate() {
            let limit = closest.map_or(T_MAX, |hit| hit.surface.t);
            let of_mesh = |mesh: u32, ray: &PreparedRay| {
                let mesh = &self.scene.geometry.meshes[mesh as usize];
                let mut nearest: Option<SurfaceHit> = None;
                for triangle in 0..mesh.triangle_count() as u32 {
                    let hit = intersect_triangle(ray, mesh.corners(triangle));
                    if let Some(hit) = hit.filter(|hit| hit.t < nearest.map_or(limit, |nearest| nearest.t)) {
                        nearest = Some(SurfaceHit { triangle, ..hit });
                    }
                }
                nearest
            };
            if let Some(surface) = object.closest_hit(&prepared, limit, of_mesh) {
                closest = Some(Hit { object: index as u32, surface });
            }
        }
        closest
    }

    pub fn surface_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.scene.geometry.surface_point(ray, hit)
    }

    pub fn seen(&self, ray: &Ray) -> Seen {
        trace_ray(&self.scene, &self.plan, *ray, Deadline::NEVER, &mut RayCounts::default()).unwrap()
    }

    pub fn color(&self, ray: &Ray) -> [f64; 3] {
        self.seen(ray).color.to_array().map(f64::from)
    }

    pub fn film(&self) -> Film {
        struct Silent;
        impl a2::render::Progress for Silent {
            fn advance(&self, _: usize, _: usize) {}
        }
        a2::render::render_uniform(&self.scene, &self.plan, &self.request, &Silent).film
    }
}

fn request(line: &str) -> a2::options::Options {
    match args::parse(line.split_whitespace().map(std::ffi::OsString::from)) {
        Ok(Request::Render(request)) => *request,
        other => panic!("{line}: {other:?}"),
    }
}

/// Makes random numbers for tests (SplitMix64), the same at every run.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number from -1 to 1.
    pub fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub fn unit(&mut self) -> [f64; 3] {
        loop {
            let v = [self.signed(), self.signed(), self.signed()];
            let length = v.map(|x| x * x).iter().sum::<f64>().sqrt();
            if length > 0.1 && length < 1.0 {
                return v.map(|x| x / length);
            }
        }
    }
}
