/* Messages to the owner of the instance. */
#include <stdarg.h>
#include <stdio.h>
#include "ropeway.h"

void rw_message(rw_instance *m, rw_status status, const char *category, const char *format, ...)
{
    char text[512];
    va_list list;
    if (!m->log || (status < RW_WARNING && !m->log_all && !m->log_events)) return;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    m->log(m->context, status, category, text);
}
