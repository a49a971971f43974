/* The end of a program by std::terminate: one line instead of an abort. */
#include "cli/session/terminate.h"

extern "C" {
#include "cli/options/options.h"
#include "io/file.h"
}

#include <exception>
#include <new>

#include <string.h>
#include <unistd.h>

namespace {

/* Memory may be exhausted: nothing here allocates. */
void print(const char* text) {
    size_t left = strlen(text);
    while (left > 0) {
        const ssize_t written = write(STDERR_FILENO, text, left);
        if (written <= 0) return;
        text += written;
        left -= size_t(written);
    }
}

void end_with_message() {
    ty_remove_unfinished_outputs();
    print("tyndall: ");
    try {
        if (std::current_exception() != nullptr) throw;
        print("a library ended the program");
    } catch (const std::bad_alloc&) {
        print("not enough memory");
    } catch (const std::exception& error) {
        print("a library failed: ");
        print(error.what());
    } catch (...) {
        print("a library failed");
    }
    print("\n");
    _exit(CLI_FAILED);
}

} /* namespace */

void cli_catch_termination(void) {
    std::set_terminate(end_with_message);
}
