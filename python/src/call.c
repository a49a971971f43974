/* Calls into the library, their errors and their log. */
#include "module.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static PyObject *make_error, *emit_log;

int load_errors(void) {
    PyObject* errors = PyImport_ImportModule("tyndall._errors");
    if (errors == NULL) return -1;
    make_error = PyObject_GetAttrString(errors, "make_error");
    emit_log = PyObject_GetAttrString(errors, "emit_log");
    Py_DECREF(errors);
    return make_error != NULL && emit_log != NULL ? 0 : -1;
}

PyObject* raise_result(ty_result result, const char* message) {
    const char* text = message[0] != '\0' ? message : ty_result_text(result);
    PyObject* error = PyObject_CallFunction(make_error, "is", (int)result, text);
    if (error != NULL) {
        PyErr_SetObject((PyObject*)Py_TYPE(error), error);
        Py_DECREF(error);
    }
    return NULL;
}

PyObject* raise_argument(const char* format, ...) {
    char text[512];
    va_list values;
    va_start(values, format);
    vsnprintf(text, sizeof text, format, values);
    va_end(values);
    return raise_result(TY_ERROR_ARGUMENT, text);
}

/* ---- the log ---- */

void context_log(void* user, ty_log_level level, const char* text) {
    context_object* context = user;
    const size_t size = strlen(text) + 1;
    log_line* line = malloc(sizeof *line + size);
    if (line == NULL) return;
    line->next = NULL;
    line->level = (int)level;
    memcpy(line->text, text, size);
    pthread_mutex_lock(&context->lock);
    if (context->last != NULL)
        context->last->next = line;
    else
        context->first = line;
    context->last = line;
    pthread_mutex_unlock(&context->lock);
}

int drain_log(context_object* context) {
    pthread_mutex_lock(&context->lock);
    log_line* line = context->first;
    context->first = context->last = NULL;
    pthread_mutex_unlock(&context->lock);
    int status = 0;
    while (line != NULL) {
        log_line* next = line->next;
        if (status == 0) {
            PyObject* done = PyObject_CallFunction(emit_log, "is", line->level, line->text);
            if (done == NULL) status = -1;
            Py_XDECREF(done);
        }
        free(line);
        line = next;
    }
    return status;
}

/* ---- long calls ---- */

bool call_progress(void* user, const ty_progress* progress) {
    call* running = user;
    pthread_mutex_lock(&running->lock);
    running->now = *progress;
    snprintf(running->stage, sizeof running->stage, "%s", progress->stage != NULL ? progress->stage : "");
    running->fresh = true;
    const bool go_on = !running->cancelled;
    pthread_mutex_unlock(&running->lock);
    return go_on;
}

static void* work(void* user) {
    call* running = user;
    running->result = running->work(running->user);
    /* messages belong to the thread that made the call */
    if (running->result != TY_OK && running->result != TY_CANCELLED)
        snprintf(running->message, sizeof running->message, "%s", ty_take_error(running->context->context));
    pthread_mutex_lock(&running->lock);
    running->finished = true;
    pthread_cond_signal(&running->wake);
    pthread_mutex_unlock(&running->lock);
    return NULL;
}

static void cancel(call* running) {
    pthread_mutex_lock(&running->lock);
    running->cancelled = true;
    pthread_mutex_unlock(&running->lock);
}

/* Keeps the current exception for call_raise, and cancels. */
static void keep_exception(call* running) {
    if (running->type == NULL)
        PyErr_Fetch(&running->type, &running->value, &running->traceback);
    else
        PyErr_Clear();
    cancel(running);
}

/* Takes the answer of a progress function, which may be an exception. */
static void heed(call* running, PyObject* answer) {
    if (answer == NULL) {
        keep_exception(running);
    } else if (answer == Py_False) {
        running->stopped = true;
        cancel(running);
    }
    Py_XDECREF(answer);
}

static PyObject* report(const call* running, const ty_progress* now, const char* stage) {
    return PyObject_CallFunction(running->progress, "sdddKK", stage, now->fraction, now->seconds, now->remaining,
                                 (unsigned long long)now->done, (unsigned long long)now->total);
}

/* Waits for the end, or a twentieth of a second; true at the end. Without the interpreter's lock. */
static bool wait_for_end(call* running, bool* fresh, ty_progress* now, char stage[64]) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += 50000000;
    if (until.tv_nsec >= 1000000000) {
        until.tv_nsec -= 1000000000;
        ++until.tv_sec;
    }
    int status = 0;
    pthread_mutex_lock(&running->lock);
    while (!running->finished && status != ETIMEDOUT)
        status = pthread_cond_timedwait(&running->wake, &running->lock, &until);
    const bool finished = running->finished;
    *fresh = running->fresh;
    running->fresh = false;
    *now = running->now;
    memcpy(stage, running->stage, sizeof running->stage);
    pthread_mutex_unlock(&running->lock);
    return finished;
}

void call_run(call* running) {
    pthread_t thread;
    bool finished = false, fresh = false;
    ty_progress now;
    char stage[64];
    pthread_mutex_init(&running->lock, NULL);
    pthread_cond_init(&running->wake, NULL);
    const bool apart = pthread_create(&thread, NULL, work, running) == 0;
    if (!apart) {
        Py_BEGIN_ALLOW_THREADS work(running);
        Py_END_ALLOW_THREADS
    }
    while (apart && !finished) {
        Py_BEGIN_ALLOW_THREADS finished = wait_for_end(running, &fresh, &now, stage);
        Py_END_ALLOW_THREADS if (!finished && PyErr_CheckSignals() != 0) keep_exception(running);
        if (fresh && running->progress != NULL && running->type == NULL && !running->stopped)
            heed(running, report(running, &now, stage));
        if (!finished && running->poll != NULL && running->type == NULL && !running->stopped)
            heed(running, running->poll(running->user));
    }
    if (apart) pthread_join(thread, NULL);
    if (drain_log(running->context) != 0) keep_exception(running);
    pthread_mutex_destroy(&running->lock);
    pthread_cond_destroy(&running->wake);
}

int call_raise(call* running, PyObject* partial) {
    if (running->type != NULL) {
        PyErr_NormalizeException(&running->type, &running->value, &running->traceback);
        if (running->value != NULL &&
            PyObject_SetAttrString(running->value, "image", partial != NULL ? partial : Py_None) != 0)
            PyErr_Clear(); /* an exception that takes no attributes */
        PyErr_Restore(running->type, running->value, running->traceback);
        running->type = running->value = running->traceback = NULL;
        return -1;
    }
    if (running->result == TY_OK || (running->result == TY_CANCELLED && partial != NULL)) return 0;
    raise_result(running->result, running->result == TY_CANCELLED
                                      ? "stopped by the progress function, which returned False"
                                      : running->message);
    return -1;
}

int call_simple(context_object* context, ty_result (*function)(void* user), void* user) {
    call running = {.context = context, .work = function, .user = user};
    call_run(&running);
    return call_raise(&running, NULL);
}
