/* Measured data in Python. */
#ifndef FACETFIT_TABLE_H
#define FACETFIT_TABLE_H
#include "bind.h"

namespace bind
{
struct table {
    table_ptr t;
    std::string path;
};

/* What the library returns as a table. */
std::unique_ptr<table> make_table(ff_table *t, const std::string &path);
} // namespace bind
#endif
