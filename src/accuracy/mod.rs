//! What a method costs and how far it errs: approximations, coarser cells and moved inputs against the exact answer.
