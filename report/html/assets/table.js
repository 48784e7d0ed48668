/* The page of a table: what the program drew, with buttons to save it. */
"use strict";
Page.begin();
