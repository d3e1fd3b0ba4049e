// Pushes the emulated knob into a wall, from Rust: `cargo run`, with bindgen's declarations, which
// build.rs has made of the installed torsio.h.
#[allow(dead_code, non_camel_case_types, non_upper_case_globals)]
mod torsio {
    include!(concat!(env!("OUT_DIR"), "/torsio.rs"));
}

use std::ffi::{CStr, CString};
use std::mem::MaybeUninit;
use std::ptr;

/// A result that is not TORSIO_OK as an error, with the library's sentence.
fn check(result: torsio::torsio_result) -> Result<(), String> {
    if result == torsio::torsio_result_TORSIO_OK {
        return Ok(());
    }
    // SAFETY: the text is this thread's, and copied before anything else is called.
    Err(unsafe { CStr::from_ptr(torsio::torsio_last_error()) }.to_string_lossy().into_owned())
}

/// A structure of torsio.h with its size and defaults.
fn filled<T>(init: unsafe extern "C" fn(*mut T) -> torsio::torsio_result) -> Result<T, String> {
    let mut structure = MaybeUninit::zeroed();
    // SAFETY: it is as large as `init` takes it to be, and `init` fills in all of it.
    unsafe {
        check(init(structure.as_mut_ptr()))?;
        Ok(structure.assume_init())
    }
}

/// An open knob that is closed when it goes out of scope.
struct Knob(*mut torsio::torsio_knob);

impl Knob {
    fn open(selector: &str) -> Result<Knob, String> {
        let selector = CString::new(selector).map_err(|error| error.to_string())?;
        let mut knob = ptr::null_mut();
        check(unsafe { torsio::torsio_knob_open(selector.as_ptr(), ptr::null(), &mut knob) })?;
        Ok(Knob(knob))
    }

    fn play(&self, wall: &torsio::torsio_wall) -> Result<(), String> {
        let mut scene = ptr::null_mut();
        unsafe {
            check(torsio::torsio_scene_new(&mut scene))?;
            let played = check(torsio::torsio_scene_add_wall(scene, wall))
                .and_then(|()| check(torsio::torsio_knob_play(self.0, scene)));
            torsio::torsio_scene_free(scene);
            played
        }
    }

    fn push(&self, torque_nm: &[torsio::torsio_knot]) -> Result<(), String> {
        let mut hand = filled(torsio::torsio_torque_hand_init)?;
        hand.torque_nm = torque_nm.as_ptr();
        hand.torque_nm_count = torque_nm.len() as _;
        check(unsafe { torsio::torsio_emulator_set_torque_hand(self.0, &hand) })
    }

    fn record(&self, duration_s: f64) -> Result<Vec<torsio::torsio_telemetry_sample>, String> {
        let mut log = ptr::null_mut();
        unsafe {
            let ended = check(torsio::torsio_knob_record(self.0, duration_s, 0.0, true, &mut log));
            let samples = match torsio::torsio_recording_count(log) {
                0 => Vec::new(),
                count => std::slice::from_raw_parts(
                    torsio::torsio_recording_samples(log),
                    count as usize,
                )
                .to_vec(),
            };
            torsio::torsio_recording_free(log);
            ended.map(|()| samples)
        }
    }
}

impl Drop for Knob {
    fn drop(&mut self) {
        unsafe { torsio::torsio_knob_free(self.0) }
    }
}

fn main() -> Result<(), String> {
    let knob = Knob::open("emulated")?;
    let mut wall = filled(torsio::torsio_wall_init)?;
    wall.angle_rad = 0.1;
    wall.stiffness_nm_per_rad = 1.4;
    knob.play(&wall)?;
    knob.push(&[
        torsio::torsio_knot { time_s: 0.0, value: 0.0 },
        torsio::torsio_knot { time_s: 1.0, value: 0.05 }, // ever harder, up to 50 mN m
    ])?;
    check(unsafe { torsio::torsio_knob_arm(knob.0) })?;

    let (mut furthest_rad, mut strongest_nm) = (0.0_f64, 0.0_f64);
    for sample in knob.record(1.5)? {
        let felt_nm = f64::from(sample.spring_torque_nm + sample.motor_command_nm);
        furthest_rad = furthest_rad.max(sample.angle_rad);
        strongest_nm = strongest_nm.max(-felt_nm);
    }
    println!("the knob was pushed to {:.3} rad, into a wall at 0.1 rad,", furthest_rad);
    println!("which pushed back with {:.0} mN m", 1e3 * strongest_nm);
    Ok(())
}
