/* tyndall: the command line tool. */
#include "cli/commands.h"
#include "cli/options.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include <tyndall/base.h>

typedef struct command {
    const char* name;
    const char* summary;
    int (*run)(int count, char** arguments);
} command;

static const command commands[] = {
    {"render", "render a scene to an image", cli_render},
    {"info", "what a scene, volume, image or mesh holds", cli_info},
    {"diff", "how an image differs from another", cli_diff},
    {"merge", "renderings of one scene to a better or larger one", cli_merge},
    {"compare", "methods or images with a reference", cli_compare},
    {"screen", "fog and water over an image with distances", cli_screen},
    {"convert", "a volume or an image as another kind of file", cli_convert},
    {"figure", "figures and tables of papers", cli_figure},
    {"bake", "light on meshes and at points, kept", cli_bake},
    {"bench", "measure speed", cli_bench},
};
enum { COMMAND_COUNT = sizeof commands / sizeof commands[0] };

static void print_help(void) {
    printf("tyndall %s: light in fog, smoke, clouds, milk and water\n\nusage: tyndall COMMAND ...\n\ncommands:\n",
           ty_version());
    for (int i = 0; i < COMMAND_COUNT; ++i) printf("  %-10s %s\n", commands[i].name, commands[i].summary);
    printf("\noptions of all commands:\n");
    cli_print_common_options();
    printf("\n'tyndall COMMAND --help' tells more. Exit status: 0 done, 1 failed while running,\n"
           "2 wrong usage or input, 130 interrupted (a valid partial result was written).\n");
}

static int unknown_command(const char* name) {
    const char* names[COMMAND_COUNT];
    char list[128] = "";
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        names[i] = commands[i].name;
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", i == 0 ? "" : ", ", names[i]);
    }
    const char* nearest = cli_nearest(name, names, COMMAND_COUNT);
    if (nearest != NULL)
        return cli_usage_error("", "unknown command '%s'; did you mean '%s'? There are: %s", name, nearest, list);
    return cli_usage_error("", "unknown command '%s'; there are: %s", name, list);
}

static int run(int count, char** arguments) {
    if (count < 2) {
        print_help();
        return CLI_USAGE;
    }
    const char* name = arguments[1];
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || strcmp(name, "help") == 0) {
        print_help();
        return CLI_DONE;
    }
    if (strcmp(name, "--version") == 0) {
        printf("tyndall %s\n", ty_version());
        return CLI_DONE;
    }
    for (int i = 0; i < COMMAND_COUNT; ++i)
        if (strcmp(name, commands[i].name) == 0) return commands[i].run(count - 2, arguments + 2);
    return unknown_command(name);
}

int main(int count, char** arguments) {
    const int status = run(count, arguments);
    if (fflush(stdout) != 0 && status == CLI_DONE) {
        fprintf(stderr, "tyndall: the result cannot be printed: %s\n", strerror(errno));
        return CLI_FAILED;
    }
    return status;
}
