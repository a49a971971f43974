/* The files of the page, which the build embeds from src/cli/view/page. */
#ifndef TY_CLI_VIEW_PAGE_FILES_H
#define TY_CLI_VIEW_PAGE_FILES_H

typedef struct view_page_file {
    const char* name; /* without folders; NULL ends the table */
    const char* text;
    unsigned size;
} view_page_file;

extern const view_page_file view_page_files[];

#endif
