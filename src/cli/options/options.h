/* The option parser of all commands: tables define the options, and --help is generated from the same tables. */
#ifndef TY_CLI_OPTIONS_OPTIONS_H
#define TY_CLI_OPTIONS_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* Exit statuses; CLI_INTERRUPTED stands for that of the signal. cli_parse returns one of them, or CLI_GO when the
 * command should run. */
enum { CLI_GO = -1, CLI_DONE = 0, CLI_FAILED = 1, CLI_USAGE = 2, CLI_INTERRUPTED = 130, CLI_NO_READER = 141 };

enum { CLI_LIST_MAX = 256, CLI_POSITIONAL_MAX = 256 };

typedef struct cli_list {
    const char* items[CLI_LIST_MAX];
    int32_t count;
} cli_list;

/* The syntax of a value and the type of its target. */
typedef enum cli_kind {
    CLI_FLAG,   /* no value; bool */
    CLI_TEXT,   /* const char* */
    CLI_LIST,   /* cli_list; the option may be given again */
    CLI_INT,    /* int32_t in [lower, upper] */
    CLI_SEED,   /* uint64_t */
    CLI_REAL,   /* double in [lower, upper] */
    CLI_SIZE,   /* int32_t[2], "800x600", each in 1..65536 */
    CLI_CROP,   /* int32_t[4], "10,20,64x48": x, y, width, height */
    CLI_CHOICE, /* int: index of a word of `value`, "auto|plain|none" */
} cli_kind;

typedef struct cli_option {
    const char* name; /* without dashes */
    char letter;      /* 0: only the long form */
    cli_kind kind;
    const char* value; /* in --help: "FILE" */
    const char* help;
    void* target; /* keeps its default when the option is not given */
    double lower, upper;
    bool* given; /* may be NULL */
} cli_option;

typedef enum cli_progress_mode { CLI_AUTO = 0, CLI_PLAIN = 1, CLI_JSON = 2, CLI_NONE = 3 } cli_progress_mode;

/* The output format of --help. */
typedef enum cli_help_form {
    CLI_HELP_TEXT = 0,
    CLI_HELP_MAN = 1,
    CLI_HELP_MARKDOWN = 2,
    CLI_HELP_COMPLETION = 3 /* functions of a shell script */
} cli_help_form;

/* The options of all commands. */
typedef struct cli_common {
    int32_t threads; /* 0: one per processor */
    uint64_t seed;
    bool seed_given;
    const char* device; /* NULL: the processor */
    int32_t resident;   /* MB of paged volumes in memory; 0: any */
    const char* stats;  /* NULL: none */
    int progress;       /* cli_progress_mode */
    bool quiet, help, version;
    int help_as;         /* cli_help_form: for `tyndall help`, and not listed */
    const char* help_to; /* output file of --help; NULL: stdout. Not listed either */
} cli_common;

/* Completion: prints the candidate words for the value of an option, or with option NULL for an argument, each followed
 * by a blank. False: no candidates; the value can be a file. */
typedef bool (*cli_words_fn)(FILE* file, const char* option);

typedef struct cli_syntax {
    const char* command; /* "render" */
    const char* usage;   /* what follows the command: "SCENE -o OUT.exr" */
    const char* summary; /* one line */
    const char* details; /* further text of --help, or NULL */
    const cli_option* options;
    int option_count;
    int positional_least, positional_most;
    cli_words_fn print_words; /* NULL: none */
} cli_syntax;

/* A parsed command line; cli_parse sets all fields. */
typedef struct cli_arguments {
    cli_common common;
    const char* positional[CLI_POSITIONAL_MAX];
    int positional_count;
} cli_arguments;

/* arguments: what follows the command's name. Errors are one sentence on stderr and CLI_USAGE; --help and --version
 * print to stdout and give CLI_DONE. */
int cli_parse(const cli_syntax* syntax, int count, char** arguments, cli_arguments* out);

/* Sets the target of an option from the text of its value, which stays the caller's; a flag's is not looked at. CLI_GO,
 * or CLI_USAGE after a message of the command. */
int cli_set_option(const char* command, const cli_option* option, const char* text);

/* The index of text among the words of "auto|plain|none", or -1. */
int cli_find_choice(const char* choices, const char* text);

/* Prints a usage error of a command (printf-like) and returns CLI_USAGE. */
int cli_usage_error(const char* command, const char* format, ...) __attribute__((format(printf, 2, 3)));

/* Parses a part I of N, like 3/8, of an option --part: CLI_GO, or CLI_USAGE after a message of the command. */
int cli_parse_part(const char* command, const char* text, int32_t part[2]);

/* Number parsing of options: decimal, finite, without leading or trailing characters. */
bool cli_parse_real(const char* text, double* out);
bool cli_parse_seed(const char* text, uint64_t* out);

enum { CLI_COMMON_COUNT = 11 };

/* The common options of all commands; values go to *common. Options without help text are not listed by --help. */
void cli_common_options(cli_common* common, cli_option options[CLI_COMMON_COUNT]);

/* The word nearest to text (edit distance at most a third of its length, at least 1), or NULL. */
const char* cli_nearest(const char* text, const char* const* words, int count);

#endif
