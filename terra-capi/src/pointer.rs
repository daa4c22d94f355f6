//! The functions C calls. Pointers are followed here and nowhere else.
#![allow(
    unsafe_code,
    reason = "a C interface takes pointers, and its names must not be mangled"
)]

use std::ffi::{CStr, c_char};

use crate::law::{TerraContact, TerraForces, TerraLaw};
use crate::status::{Failure, TerraStatus, guarded, last_message, status};

fn null(what: &str) -> Failure {
    Failure(TerraStatus::BadPointer, format!("{what} is null"))
}

/// # Safety
/// `text` is null or a text that ends in NUL and lives for `'a`.
unsafe fn words<'a>(text: *const c_char, what: &str) -> Result<&'a str, Failure> {
    if text.is_null() {
        return Err(null(what));
    }
    // SAFETY: not null; the caller vouches for the rest.
    unsafe { CStr::from_ptr(text) }
        .to_str()
        .map_err(|_| Failure(TerraStatus::BadPointer, format!("{what} is not UTF-8")))
}

/// # Safety
/// `pointer` is null or points to a valid value that nobody changes during `'a`.
unsafe fn read<'a, T>(pointer: *const T, what: &str) -> Result<&'a T, Failure> {
    // SAFETY: the caller vouches for it.
    unsafe { pointer.as_ref() }.ok_or_else(|| null(what))
}

/// # Safety
/// `pointer` is null or points to a valid value that nobody else uses during `'a`.
unsafe fn write<'a, T>(pointer: *mut T, what: &str) -> Result<&'a mut T, Failure> {
    // SAFETY: the caller vouches for it.
    unsafe { pointer.as_mut() }.ok_or_else(|| null(what))
}

/// Version of this interface; equals TERRA_ABI_VERSION of the header it was made with.
#[unsafe(no_mangle)]
pub extern "C" fn terra_abi_version() -> u32 {
    1
}

/// What went wrong in the last call on this thread; empty when nothing did. Valid until the next call on this thread.
#[unsafe(no_mangle)]
pub extern "C" fn terra_last_error() -> *const c_char {
    last_message(CStr::as_ptr)
}

/// A law by name: "wong-reece", or with effects "wong-reece+slip-sinkage". Set its parameters before it is asked for
/// forces.
///
/// # Safety
/// `model` is a text that ends in NUL, `out` a place for the handle; free it with terra_law_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terra_law_new(
    model: *const c_char,
    out: *mut *mut TerraLaw,
) -> TerraStatus {
    guarded(|| {
        // SAFETY: as documented above.
        let (out, model) = unsafe { (write(out, "out")?, words(model, "model")?) };
        *out = std::ptr::null_mut();
        *out = Box::into_raw(Box::new(TerraLaw::new(model)?));
        Ok(())
    })
}

/// Frees a law; null is allowed.
///
/// # Safety
/// `law` comes from terra_law_new and is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terra_law_free(law: *mut TerraLaw) {
    if !law.is_null() {
        // SAFETY: made by Box::into_raw, freed once.
        drop(unsafe { Box::from_raw(law) });
    }
}

/// Number of parameters: the model's, then the magnitudes of the effects. 0 for null.
///
/// # Safety
/// `law` is null or comes from terra_law_new.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terra_law_parameter_count(law: *const TerraLaw) -> usize {
    // SAFETY: as documented above.
    unsafe { law.as_ref() }.map_or(0, |l| l.names().len())
}

/// Name of a parameter ("friction_angle", "slip-sinkage.magnitude"); null beyond the last. Lives as long as the law.
///
/// # Safety
/// `law` is null or comes from terra_law_new.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terra_law_parameter_name(
    law: *const TerraLaw,
    index: usize,
) -> *const c_char {
    // SAFETY: as documented above.
    let name = unsafe { law.as_ref() }.and_then(|l| l.names().get(index));
    name.map_or(std::ptr::null(), |n| n.as_ptr())
}

/// Sets the model's parameters to those of a soil of the catalogue ("dry_sand"; `terra terrains` lists them).
///
/// # Safety
/// `law` comes from terra_law_new, `terrain` is a text that ends in NUL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terra_law_set_terrain(
    law: *mut TerraLaw,
    terrain: *const c_char,
) -> TerraStatus {
    guarded(|| {
        // SAFETY: as documented above.
        let (law, terrain) = unsafe { (write(law, "law")?, words(terrain, "terrain")?) };
        law.set_terrain(terrain)
    })
}

/// Sets one parameter, in SI units and radians.
///
/// # Safety
/// `law` comes from terra_law_new, `name` is a text that ends in NUL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terra_law_set_parameter(
    law: *mut TerraLaw,
    name: *const c_char,
    value: f64,
) -> TerraStatus {
    guarded(|| {
        // SAFETY: as documented above.
        let (law, name) = unsafe { (write(law, "law")?, words(name, "name")?) };
        law.set(name, value)
    })
}

/// The value of a parameter; NaN when it was never set.
///
/// # Safety
/// `law` comes from terra_law_new, `name` is a text that ends in NUL, `out` a place for the value.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terra_law_get_parameter(
    law: *const TerraLaw,
    name: *const c_char,
    out: *mut f64,
) -> TerraStatus {
    guarded(|| {
        // SAFETY: as documented above.
        let (law, name, out) =
            unsafe { (read(law, "law")?, words(name, "name")?, write(out, "out")?) };
        *out = law.get(name)?;
        Ok(())
    })
}

/// Forces of the ground on one wheel.
///
/// # Safety
/// `law` comes from terra_law_new; `contact` and `out` point to one of their kind.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terra_law_forces(
    law: *const TerraLaw,
    contact: *const TerraContact,
    out: *mut TerraForces,
) -> TerraStatus {
    guarded(|| {
        // SAFETY: as documented above.
        let (law, contact, out) = unsafe {
            (
                read(law, "law")?,
                read(contact, "contact")?,
                write(out, "out")?,
            )
        };
        *out = TerraForces::NONE;
        *out = law.forces(contact)?;
        Ok(())
    })
}

/// Forces of many wheels. Each has its own status in `statuses` (which may be null); the return value is the first that is
/// not TERRA_STATUS_OK.
///
/// # Safety
/// `law` comes from terra_law_new; `contacts`, `out` and `statuses`, where not null, point to `count` of their kind.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terra_law_forces_many(
    law: *const TerraLaw,
    contacts: *const TerraContact,
    count: usize,
    out: *mut TerraForces,
    statuses: *mut TerraStatus,
) -> TerraStatus {
    guarded(|| {
        if count == 0 {
            return Ok(());
        }
        // SAFETY: as documented above.
        let law = unsafe {
            read(contacts, "contacts")?;
            write(out, "out")?;
            read(law, "law")?
        };
        let mut first = None;
        for k in 0..count {
            // SAFETY: k is below the count the caller vouches for; all pointers but statuses are known not to be null.
            let (contact, out) = unsafe { (&*contacts.add(k), &mut *out.add(k)) };
            let found = law.forces(contact);
            let ended = found.as_ref().map_or_else(status, |_| TerraStatus::Ok);
            if !statuses.is_null() {
                // SAFETY: as above.
                unsafe { *statuses.add(k) = ended };
            }
            *out = match found {
                Ok(forces) => forces,
                Err(e) => {
                    first.get_or_insert(Failure(ended, format!("contact {k}: {e}")));
                    TerraForces::NONE
                }
            };
        }
        first.map_or(Ok(()), Err)
    })
}

/// Forces, and their exact slopes for an implicit integrator: `slopes` receives six numbers, drawbar pull by slip and by
/// load, torque by slip and by load, sinkage by slip and by load.
///
/// # Safety
/// As terra_law_forces; `slopes` points to six numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terra_law_forces_and_slopes(
    law: *const TerraLaw,
    contact: *const TerraContact,
    out: *mut TerraForces,
    slopes: *mut f64,
) -> TerraStatus {
    guarded(|| {
        // SAFETY: as documented above; an array of six is laid out as six numbers.
        let (law, contact, out, slopes) = unsafe {
            (
                read(law, "law")?,
                read(contact, "contact")?,
                write(out, "out")?,
                write(slopes.cast::<[f64; 6]>(), "slopes")?,
            )
        };
        (*out, *slopes) = (TerraForces::NONE, [f64::NAN; 6]);
        (*out, *slopes) = law.slopes(contact)?;
        Ok(())
    })
}
