#!/usr/bin/env python3
"""Runs a program on a bus of its own: in a network namespace with multicast on its loopback.

usage: in_private_network.py PROGRAM [ARGUMENT...]
Exit: the program's; 77 where namespaces or large receive buffers are not allowed (says why).
"""
import os
import sys

from live_system import enter_private_network

enter_private_network()
os.execvp(sys.argv[1], sys.argv[1:])
