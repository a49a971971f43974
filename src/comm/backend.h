/* The table of functions that a module with a message-passing library gives to the program that loads it. */
#ifndef TY_COMM_BACKEND_H
#define TY_COMM_BACKEND_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Of this table: a module of another build is refused. */
#define TY_COMM_BACKEND_VERSION 2u

/* A message that has arrived: its sender, its tag and its bytes. */
typedef struct ty_comm_message {
    int32_t from, tag;
    size_t size;
} ty_comm_message;

/* A message of a size that both sides know, under way between this rank and another. Transfers of the same direction,
 * rank and tag are matched in the order in which they were posted. */
typedef struct ty_comm_transfer {
    int32_t rank, tag; /* the other rank; a tag from 0 on, below TY_COMM_TAGS */
    void* bytes;       /* to send, or to receive into; they stay until it is done */
    size_t size;       /* at most TY_COMM_TRANSFER_MAX */
    bool receives, done;
    uint64_t handle; /* the library's */
} ty_comm_transfer;

enum { TY_COMM_TAGS = 1 << 14, TY_COMM_TRANSFER_MAX = 1 << 30 };

/* Calls come from one thread at a time. A false result means that the library failed. */
typedef struct ty_comm_backend {
    uint32_t version;
    /* Joins the other ranks, all of which call it. */
    bool (*open)(int32_t* rank, int32_t* size);
    bool (*send)(int32_t to, int32_t tag, const void* bytes, size_t size);
    /* True if a message has arrived; it does not wait. */
    bool (*probe)(ty_comm_message* out);
    /* Receives a message that `probe` found. */
    bool (*receive)(const ty_comm_message* message, void* bytes);
    /* Begins a transfer; `probe` does not see it. */
    bool (*post)(ty_comm_transfer* transfer);
    /* Sets `done` of a transfer that is over. */
    bool (*test)(ty_comm_transfer* transfer);
    /* Leaves, after all ranks have called it. */
    void (*close)(void);
    /* Ends all ranks with an exit status. */
    void (*abort)(int status);
} ty_comm_backend;

/* The one symbol of a module, a ty_comm_backend. */
#define TY_COMM_BACKEND_SYMBOL "ty_comm_module"

#endif
