/* The module over MPI, the only file that sees its header. It is loaded where a launcher of MPI started the program. */
#include "comm/backend.h"

#include <limits.h>
#include <mpi.h>
#include <string.h>

/* Of transfers, so that probes for messages of any rank do not find them. */
static MPI_Comm transfers;
_Static_assert(sizeof(MPI_Request) <= sizeof(uint64_t), "a transfer's handle holds the request");

/* Serialized: the threads of rank 0 call one after another. */
static bool mpi_open(int32_t* rank, int32_t* size) {
    int provided = MPI_THREAD_SINGLE, own = 0, all = 0;
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &provided) != MPI_SUCCESS) return false;
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI_Comm_rank(MPI_COMM_WORLD, &own);
    MPI_Comm_size(MPI_COMM_WORLD, &all);
    *rank = own;
    *size = all;
    if (MPI_Comm_dup(MPI_COMM_WORLD, &transfers) != MPI_SUCCESS) return false;
    MPI_Comm_set_errhandler(transfers, MPI_ERRORS_RETURN);
    return provided >= MPI_THREAD_SERIALIZED;
}

/* The longest time that a message may take. A rank that died makes no call fail: its messages never end. */
static const double message_seconds = 10;

static bool finish(MPI_Request* request) {
    int done = 0;
    const double begun = MPI_Wtime();
    while (MPI_Test(request, &done, MPI_STATUS_IGNORE) == MPI_SUCCESS && done == 0)
        if (MPI_Wtime() - begun > message_seconds) break;
    if (done == 0) MPI_Request_free(request);
    return done != 0;
}

static bool mpi_send(int32_t to, int32_t tag, const void* bytes, size_t size) {
    MPI_Request request;
    return size <= INT_MAX && MPI_Isend(bytes, (int)size, MPI_BYTE, to, tag, MPI_COMM_WORLD, &request) == MPI_SUCCESS &&
           finish(&request);
}

static bool mpi_probe(ty_comm_message* out) {
    MPI_Status status;
    int there = 0, count = 0;
    if (MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &there, &status) != MPI_SUCCESS || there == 0)
        return false;
    MPI_Get_count(&status, MPI_BYTE, &count);
    *out = (ty_comm_message){status.MPI_SOURCE, status.MPI_TAG, (size_t)count};
    return true;
}

static bool mpi_receive(const ty_comm_message* message, void* bytes) {
    MPI_Request request;
    return MPI_Irecv(bytes, (int)message->size, MPI_BYTE, message->from, message->tag, MPI_COMM_WORLD, &request) ==
               MPI_SUCCESS &&
           finish(&request);
}

static bool mpi_post(ty_comm_transfer* t) {
    MPI_Request request;
    const int size = (int)t->size;
    const int result = t->receives ? MPI_Irecv(t->bytes, size, MPI_BYTE, t->rank, t->tag, transfers, &request)
                                   : MPI_Isend(t->bytes, size, MPI_BYTE, t->rank, t->tag, transfers, &request);
    memcpy(&t->handle, &request, sizeof request);
    return result == MPI_SUCCESS;
}

static bool mpi_test(ty_comm_transfer* t) {
    MPI_Request request;
    MPI_Status status;
    int done = 0, count = 0;
    memcpy(&request, &t->handle, sizeof request);
    if (MPI_Test(&request, &done, &status) != MPI_SUCCESS) return false;
    memcpy(&t->handle, &request, sizeof request);
    t->done = done != 0;
    if (!t->done || !t->receives) return true;
    MPI_Get_count(&status, MPI_BYTE, &count);
    return (size_t)count == t->size;
}

static void mpi_close(void) {
    MPI_Comm_free(&transfers);
    MPI_Finalize();
}

static void mpi_abort(int status) {
    MPI_Abort(MPI_COMM_WORLD, status);
}

extern const ty_comm_backend ty_comm_module;
__attribute__((visibility("default"))) const ty_comm_backend ty_comm_module = {
    TY_COMM_BACKEND_VERSION, mpi_open, mpi_send, mpi_probe, mpi_receive, mpi_post, mpi_test, mpi_close, mpi_abort};
