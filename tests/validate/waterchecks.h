/* Parts of `make validate-water`: all orders with the phase functions of sea
 * water against waterrays.h, and against published numbers. Each writes its
 * tables and says whether its bound is kept. */
#pragma once

#include <stdbool.h>
#include <stdio.h>

bool check_rays(FILE *md, bool quick);
bool check_published(FILE *md);
