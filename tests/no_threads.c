/* A library to preload: no thread can be started, as where the limit of processes is reached. Each attempt writes a
 * line to stderr. */
#include <errno.h>
#include <pthread.h>
#include <stdio.h>

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*body)(void*), void* user) {
    (void)thread;
    (void)attributes;
    (void)body;
    (void)user;
    fputs("a thread is wanted\n", stderr);
    return EAGAIN;
}
