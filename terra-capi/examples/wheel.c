/* The force-slip curve of one wheel on dry sand, as a simulator would ask for it.
 *
 *   cc wheel.c -I ../include -L ../../target/release -lterra_capi -o wheel
 */
#include <stdio.h>
#include <string.h>

#include "terra.h"

static int fail(const char *what) {
    fprintf(stderr, "%s: %s\n", what, terra_last_error());
    return 1;
}

int main(void) {
    if (terra_abi_version() != TERRA_ABI_VERSION) {
        fprintf(stderr, "header and library differ\n");
        return 1;
    }
    TerraLaw *law = NULL;
    if (terra_law_new("wong-reece+slip-sinkage", &law) != TERRA_STATUS_OK) return fail("law");
    if (terra_law_set_terrain(law, "dry_sand") != TERRA_STATUS_OK) return fail("terrain");
    if (terra_law_set_parameter(law, "slip-sinkage.magnitude", 0.3) != TERRA_STATUS_OK) return fail("magnitude");

    TerraContact contact;
    memset(&contact, 0, sizeof contact);
    contact.normal_load = 245.25;
    contact.radius = 0.254;
    contact.width = 0.15;
    printf("slip,drawbar_pull_N,torque_N_m,sinkage_m\n");
    for (int k = 1; k <= 9; ++k) {
        contact.slip = k / 10.0;
        TerraForces forces;
        double slopes[6];
        if (terra_law_forces_and_slopes(law, &contact, &forces, slopes) != TERRA_STATUS_OK) return fail("forces");
        printf("%.17g,%.17g,%.17g,%.17g\n", contact.slip, forces.drawbar_pull, forces.resistive_torque, forces.sinkage);
    }

    /* A load that the soil cannot carry is a status, not a number. */
    contact.normal_load = 1e9;
    TerraForces forces;
    TerraStatus status = terra_law_forces(law, &contact, &forces);
    if (status != TERRA_STATUS_NO_EQUILIBRIUM || forces.drawbar_pull == forces.drawbar_pull) return 1;
    TerraLaw *none = NULL;
    if (terra_law_new("wong-rece", &none) != TERRA_STATUS_UNKNOWN_NAME || none != NULL) return 1;
    fprintf(stderr, "%s\n", terra_last_error());
    terra_law_free(none);
    terra_law_free(law);
    return 0;
}
