/* The processes of one command ("ranks"): how many there are, messages between them, and an end for all of them.
 * Where no launcher started the program there is one rank, no library is loaded, and a NULL ty_comm stands for it. */
#ifndef TY_COMM_COMM_H
#define TY_COMM_COMM_H

#include "comm/backend.h"

#include <tyndall/base.h>

typedef struct ty_comm ty_comm;

/* The rank and the number of ranks that a launcher of MPI tells its processes in their environment, without any call of
 * MPI: true if there are several. */
bool ty_comm_launched(int32_t* rank, int32_t* size);

/* Joins the other ranks through the module at a path, where a launcher started several; otherwise *out is NULL. A rank
 * that waits for the others longer than `seconds` prints one line and ends with the status 2. Errors, with a message of
 * no context: TY_ERROR_UNSUPPORTED: there is no module, or it cannot be used. */
ty_result ty_comm_open(const char* module, double seconds, ty_comm** out);
/* The same through a table of functions, for the rank that a launcher told. */
ty_result ty_comm_join(const ty_comm_backend* backend, double seconds, int32_t rank, ty_comm** out);
/* So many ranks that are not there, for plans: only their number may be asked for. NULL: one rank, or no memory. */
ty_comm* ty_comm_plan(int32_t ranks);
/* Leaves. `all`: every rank is known to leave; otherwise some have died, and the call does not wait for them. Where the
 * others do not leave within ten seconds the program ends with a status. */
void ty_comm_close(ty_comm* comm, bool all, int status);

/* Of one rank, for NULL: 0 and 1. */
int32_t ty_comm_rank(const ty_comm* comm);
int32_t ty_comm_size(const ty_comm* comm);

/* Sends a message; the receiver must be waiting for one. False: it is gone. Calls of several threads follow one
 * another. */
bool ty_comm_send(ty_comm* comm, int32_t to, int32_t tag, const void* bytes, size_t size);
/* Waits up to some seconds for a message of any rank; the thread sleeps meanwhile. */
bool ty_comm_wait(ty_comm* comm, double seconds, ty_comm_message* out);
/* Receives the message that ty_comm_wait found; false: it failed, and the bytes are undefined. */
bool ty_comm_receive(ty_comm* comm, const ty_comm_message* message, void* bytes);

/* ---- transfers: between ranks that know what comes ---- */

/* Begins transfers, and waits for them, so that others may be computed meanwhile. For NULL there are none. False: a
 * rank does not answer (ty_comm_lost), from then on for all transfers at once. */
bool ty_comm_post(ty_comm* comm, ty_comm_transfer* transfers, int32_t count);
bool ty_comm_finish(ty_comm* comm, ty_comm_transfer* transfers, int32_t count);
/* Looks whether a transfer is done, without waiting. */
bool ty_comm_is_done(ty_comm* comm, ty_comm_transfer* transfer);
/* Sends a copy of bytes, and returns at once; waits for bytes of a rank. Many may be in flight. */
bool ty_comm_put(ty_comm* comm, int32_t to, int32_t tag, const void* bytes, size_t size);
bool ty_comm_get(ty_comm* comm, int32_t from, int32_t tag, void* bytes, size_t size);
/* Sends or receives bytes in any number, and waits for their end. */
bool ty_comm_move(ty_comm* comm, int32_t rank, bool receives, void* bytes, size_t size);

/* Calls of all ranks, in the same order. Rank r's bytes are [offsets[r], offsets[r + 1]) of `all`.
 * `gather` brings all to rank 0, `gather_all` (at most TY_COMM_TRANSFER_MAX bytes) to every rank, from where they are
 * in the rank's own `all`; `broadcast` sends those of rank 0. Sums are made in the order of ranks, so that they are the
 * same on all of them. */
bool ty_comm_gather(ty_comm* comm, void* all, const size_t* offsets);
bool ty_comm_gather_all(ty_comm* comm, void* all, const size_t* offsets);
bool ty_comm_broadcast(ty_comm* comm, void* bytes, size_t size);
bool ty_comm_sum(ty_comm* comm, double* values, int32_t count);
bool ty_comm_max(ty_comm* comm, double* values, int32_t count);

/* The rank that transfers were waiting for in vain, or -1. */
int32_t ty_comm_lost(const ty_comm* comm);

/* Ends all ranks at once with an exit status. */
void ty_comm_abort(ty_comm* comm, int status) __attribute__((noreturn));

/* Messages sent and received by this rank, and their bytes. */
typedef struct ty_comm_traffic {
    uint64_t messages, bytes;
} ty_comm_traffic;
ty_comm_traffic ty_comm_get_traffic(const ty_comm* comm);

#endif
