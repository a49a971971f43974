/* Methods whose solve is divided among the ranks of a command (comm/joint.h). */
#ifndef TY_METHOD_JOINT_H
#define TY_METHOD_JOINT_H

#include "comm/joint.h"

#include <tyndall/scene.h>

/* Another rank: the scene is that of rank 0. */
typedef struct ty_joint_helper {
    const ty_scene* scene;
    ty_joint_rank rank;
} ty_joint_helper;

/* The worker of TY_JOB_JOINT for a scene, which stays the caller's, as the helper does. */
ty_job_worker ty_joint_worker(ty_joint_helper* helper, ty_comm* comm, const ty_scene* scene);

#endif
