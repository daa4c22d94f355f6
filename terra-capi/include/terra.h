/* terra: the force of the ground on a wheel. SI units and radians throughout.
 *
 * Every function that can fail returns a TerraStatus; terra_last_error() says in words what went wrong on this thread.
 * A TerraLaw may be read from several threads at once; it may be changed from one.
 *
 * Made from the Rust sources by cbindgen; do not edit. */

#ifndef TERRA_H
#define TERRA_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#define TERRA_ABI_VERSION 1

// How a call ended.
typedef enum TerraStatus {
  // Done.
  TERRA_STATUS_OK = 0,
  // The soil cannot carry the load; the forces are NaN.
  TERRA_STATUS_NO_EQUILIBRIUM = 1,
  // A parameter or a quantity of the contact is out of range.
  TERRA_STATUS_OUT_OF_RANGE = 2,
  // No model, effect, terrain or parameter has that name.
  TERRA_STATUS_UNKNOWN_NAME = 3,
  // Model and effects do not go together, or the terrain lacks a value that the model needs.
  TERRA_STATUS_NOT_APPLICABLE = 4,
  // The iteration for the sinkage did not settle.
  TERRA_STATUS_NOT_CONVERGED = 5,
  // A null pointer, or text that is not UTF-8.
  TERRA_STATUS_BAD_POINTER = 6,
  // A fault of terra itself.
  TERRA_STATUS_INTERNAL = 7,
} TerraStatus;

// A terrain model with effects and the values of their parameters. Opaque.
typedef struct TerraLaw TerraLaw;

// One wheel's contact. Fill it with zeros, then set what is known; slip, load, radius and width must be.
typedef struct TerraContact {
  // Slip in [-1, 1]: driving 1 - v/(R w), braking R w/v - 1.
  double slip;
  // Normal load, N.
  double normal_load;
  // Wheel radius, m.
  double radius;
  // Wheel width, m.
  double width;
  // Speed of the wheel centre, m/s; 0 when unknown.
  double speed;
  // Slip angle, rad: the wheel moves to the left of where it points.
  double slip_angle;
  // Earlier passes over this track; 0 on virgin soil.
  double earlier_passes;
} TerraContact;

// What the ground gives the wheel. NaN for what the model does not have.
typedef struct TerraForces {
  // Net forward force, N.
  double drawbar_pull;
  // Torque against the drive, N m.
  double resistive_torque;
  // Sideways force, N, to the left.
  double lateral_force;
  // Depth below the undisturbed surface, m.
  double sinkage;
  // Entry angle, rad from the downward vertical.
  double entry_angle;
} TerraForces;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Version of this interface; equals TERRA_ABI_VERSION of the header it was made with.
uint32_t terra_abi_version(void);

// What went wrong in the last call on this thread; empty when nothing did. Valid until the next call on this thread.
const char *terra_last_error(void);

// A law by name: "wong-reece", or with effects "wong-reece+slip-sinkage". Set its parameters before it is asked for
// forces.
//
// # Safety
// `model` is a text that ends in NUL, `out` a place for the handle; free it with terra_law_free.
enum TerraStatus terra_law_new(const char *model,
                               struct TerraLaw **out);

// Frees a law; null is allowed.
//
// # Safety
// `law` comes from terra_law_new and is not used again.
void terra_law_free(struct TerraLaw *law);

// Number of parameters: the model's, then the magnitudes of the effects. 0 for null.
//
// # Safety
// `law` is null or comes from terra_law_new.
size_t terra_law_parameter_count(const struct TerraLaw *law);

// Name of a parameter ("friction_angle", "slip-sinkage.magnitude"); null beyond the last. Lives as long as the law.
//
// # Safety
// `law` is null or comes from terra_law_new.
const char *terra_law_parameter_name(const struct TerraLaw *law,
                                     size_t index);

// Sets the model's parameters to those of a soil of the catalogue ("dry_sand"; `terra terrains` lists them).
//
// # Safety
// `law` comes from terra_law_new, `terrain` is a text that ends in NUL.
enum TerraStatus terra_law_set_terrain(struct TerraLaw *law,
                                       const char *terrain);

// Sets one parameter, in SI units and radians.
//
// # Safety
// `law` comes from terra_law_new, `name` is a text that ends in NUL.
enum TerraStatus terra_law_set_parameter(struct TerraLaw *law, const char *name, double value);

// The value of a parameter; NaN when it was never set.
//
// # Safety
// `law` comes from terra_law_new, `name` is a text that ends in NUL, `out` a place for the value.
enum TerraStatus terra_law_get_parameter(const struct TerraLaw *law, const char *name, double *out);

// Forces of the ground on one wheel.
//
// # Safety
// `law` comes from terra_law_new; `contact` and `out` point to one of their kind.
enum TerraStatus terra_law_forces(const struct TerraLaw *law,
                                  const struct TerraContact *contact,
                                  struct TerraForces *out);

// Forces of many wheels. Each has its own status in `statuses` (which may be null); the return value is the first that is
// not TERRA_STATUS_OK.
//
// # Safety
// `law` comes from terra_law_new; `contacts`, `out` and `statuses`, where not null, point to `count` of their kind.
enum TerraStatus terra_law_forces_many(const struct TerraLaw *law,
                                       const struct TerraContact *contacts,
                                       size_t count,
                                       struct TerraForces *out,
                                       enum TerraStatus *statuses);

// Forces, and their exact slopes for an implicit integrator: `slopes` receives six numbers, drawbar pull by slip and by
// load, torque by slip and by load, sinkage by slip and by load.
//
// # Safety
// As terra_law_forces; `slopes` points to six numbers.
enum TerraStatus terra_law_forces_and_slopes(const struct TerraLaw *law,
                                             const struct TerraContact *contact,
                                             struct TerraForces *out,
                                             double *slopes);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TERRA_H */
