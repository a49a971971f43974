#include "method/joint.h"

#include "scene/scene.h"
#include "solve/diffusion/divided/joint.h"
#include "solve/ordinates/divided/joint_solve.h"

static void take_part_in_diffusion(ty_comm* comm, void* user, const uint8_t* bytes, size_t size) {
    const ty_joint_helper* helper = user;
    ty_diffusion_take_part(comm, ty_scene_context(helper->scene), bytes, size);
}

static void take_part_in_ordinates(ty_comm* comm, void* user, const uint8_t* bytes, size_t size) {
    const ty_joint_helper* helper = user;
    ty_ordinates_join(ty_scene_context(helper->scene), comm, bytes, size);
}

/* One entry for each method whose solve is divided. */
static const ty_joint_solver solvers[TY_JOINT_KINDS] = {
    [TY_JOINT_DIFFUSION] = take_part_in_diffusion, [TY_JOINT_ORDINATES] = take_part_in_ordinates};

ty_job_worker ty_joint_worker(ty_joint_helper* helper, ty_comm* comm, const ty_scene* scene) {
    *helper = (ty_joint_helper){scene, {comm, solvers, helper}};
    return ty_joint_job_worker(&helper->rank);
}
