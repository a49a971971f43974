/* Solves that all ranks of a command make together ("joint"): rank 0 begins one, and every other rank takes part in it
 * through the same calls of comm/comm.h. Tasks (comm/queue.h) are for work that ranks may do alone. */
#ifndef TY_COMM_JOINT_H
#define TY_COMM_JOINT_H

#include "comm/queue.h"

/* The solvers; each has a function for the other ranks (ty_joint_solver). */
typedef enum ty_joint_kind { TY_JOINT_DIFFUSION, TY_JOINT_ORDINATES, TY_JOINT_KINDS } ty_joint_kind;

/* On rank 0: begins a solve, described by bytes. The result is the comm of all ranks, through which it is made; NULL:
 * rank 0 makes it alone, because there is no queue, a rank is lost, or one cannot take part. */
ty_comm* ty_joint_begin(ty_work_queue* queue, ty_joint_kind kind, const void* bytes, size_t size);

/* On the other ranks: takes part in one solve. user: ty_joint_rank.user. */
typedef void (*ty_joint_solver)(ty_comm* comm, void* user, const uint8_t* bytes, size_t size);

/* Another rank. */
typedef struct ty_joint_rank {
    ty_comm* comm;
    const ty_joint_solver* solvers; /* TY_JOINT_KINDS of them; NULL: refuses */
    void* user;
} ty_joint_rank;

/* The worker of TY_JOB_JOINT; the rank stays the caller's. */
ty_job_worker ty_joint_job_worker(ty_joint_rank* rank);

#endif
