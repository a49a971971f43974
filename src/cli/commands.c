/* The table of commands. */
#include "cli/commands.h"
#include "cli/options/options.h"

#include <stdio.h>
#include <string.h>

const cli_command cli_commands[CLI_COMMAND_COUNT] = {
    {"render", "render a scene to an image", cli_render, false, true},
    {"view", "a scene in the browser, live", cli_view, false, true},
    {"info", "what a scene, volume, image or mesh holds", cli_info, false, false},
    {"diff", "how an image differs from another", cli_diff, false, false},
    {"merge", "renderings of one scene to a better or larger one", cli_merge, false, false},
    {"denoise", "a path-traced image without its noise", cli_denoise, false, false},
    {"compare", "methods or images with a reference", cli_compare, false, true},
    {"screen", "fog and water over an image with distances", cli_screen, false, false},
    {"convert", "a volume or an image as another kind of file", cli_convert, false, false},
    {"flux", "fluxes through levels, absorbed power and radiance", cli_flux, false, false},
    {"fluence", "the fluence of a scene as a volume", cli_fluence, false, true},
    {"figure", "figures and tables of papers", cli_figure, true, false},
    {"bake", "precomputed light on meshes and at points", cli_bake, false, true},
    {"unwrap", "texture coordinates for lightmaps", cli_unwrap, false, false},
    {"export", "a bake as an engine loads it", cli_export, false, false},
    {"bench", "measure speed", cli_bench, true, false},
    {"help", "what a command does, and manual pages", cli_help, false, false},
};

const cli_command* cli_find_command(const char* asker, const char* name) {
    const char* names[CLI_COMMAND_COUNT];
    char list[160] = "";
    for (int i = 0; i < CLI_COMMAND_COUNT; ++i) {
        if (strcmp(name, cli_commands[i].name) == 0) return &cli_commands[i];
        names[i] = cli_commands[i].name;
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", i == 0 ? "" : ", ", names[i]);
    }
    const char* nearest = cli_nearest(name, names, CLI_COMMAND_COUNT);
    if (nearest != NULL)
        cli_usage_error(asker, "unknown command '%s'; did you mean '%s'? There are: %s", name, nearest, list);
    else
        cli_usage_error(asker, "unknown command '%s'; there are: %s", name, list);
    return NULL;
}
