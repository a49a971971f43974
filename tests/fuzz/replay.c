/* Runs files, or all files of folders, through a fuzz target: what a build without libFuzzer links as main. */
#include "fuzz_target.h"

#include <dirent.h>
#include <stdio.h>

static int replay_file(const char* path) {
    FILE* stream = fopen(path, "rb");
    if (stream == NULL || fseek(stream, 0, SEEK_END) != 0) {
        fprintf(stderr, "cannot read %s\n", path);
        if (stream != NULL) fclose(stream);
        return 1;
    }
    const long size = ftell(stream);
    rewind(stream);
    uint8_t* bytes = malloc((size_t)size + 1);
    const size_t got = bytes == NULL ? 0 : fread(bytes, 1, (size_t)size, stream);
    fclose(stream);
    if (got == (size_t)size) LLVMFuzzerTestOneInput(bytes, got);
    free(bytes);
    return got == (size_t)size ? 0 : 1;
}

static int replay_folder(DIR* folder, const char* path, int* files) {
    int failures = 0;
    for (struct dirent* entry; (entry = readdir(folder)) != NULL;) {
        if (entry->d_name[0] == '.') continue;
        char name[4096];
        snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
        failures += replay_file(name);
        ++*files;
    }
    return failures;
}

int main(int count, char** arguments) {
    int failures = 0, files = 0;
    for (int i = 1; i < count; ++i) {
        DIR* folder = opendir(arguments[i]);
        if (folder != NULL) {
            failures += replay_folder(folder, arguments[i], &files);
            closedir(folder);
        } else {
            failures += replay_file(arguments[i]);
            ++files;
        }
    }
    printf("%d files replayed\n", files);
    return failures == 0 && files > 0 ? 0 : 1;
}
