#include "method/joint.h"

/* One entry for each method whose solve is divided. */
static const ty_joint_solver solvers[TY_JOINT_KINDS] = {0};

ty_job_worker ty_joint_worker(ty_joint_helper* helper, ty_comm* comm, const ty_scene* scene) {
    *helper = (ty_joint_helper){scene, {comm, solvers, helper}};
    return ty_joint_job_worker(&helper->rank);
}
