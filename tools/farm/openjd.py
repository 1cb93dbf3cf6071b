# SPDX-License-Identifier: Apache-2.0
"""The same tasks and merges as a job template of Open Job Description [specification 2023-09], for the queues that read it.
JSON, which every reader of templates takes."""
import json
import re

from . import folder, merging, scripts, submit


def step(name, script, fixed, count, after):
    """A step of so many tasks; `fixed` are words in front of the task's number."""
    made = {"name": name,
            "parameterSpace": {"taskParameterDefinitions": [{"name": "Task", "type": "INT", "range": f"0-{count - 1}"}]},
            "script": {"actions": {"onRun": {
                "command": "bash", "args": [f"{{{{Param.Farm}}}}/{script}", *fixed, "{{Task.Param.Task}}"],
                # eikon saves when it is told to end, and continues from there.
                "cancelation": {"mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": 90}}}}}
    if after:
        made["dependencies"] = [{"dependsOn": after}]
    return made


def template(farm, tasks, levels):
    """The template of a farm's tasks, and its merges level by level."""
    steps = [step("Render", "openjd-task.sh", [], tasks, None)]
    for level, merges in enumerate(levels):
        steps.append(step(f"Merge{level}", "openjd-merge.sh", [str(level)], merges, steps[-1]["name"]))
    for one in steps:
        one["hostRequirements"] = {"amounts": [{"name": "amount.worker.memory", "min": farm.settings["memory_mb"]},
                                               {"name": "amount.worker.vcpu", "min": farm.settings["threads"] or 1}]}
    # Braces in a name would stand for a value, and what does not print is not allowed.
    name = re.sub(r"[{}\x00-\x1f\x7f-\x9f]+", "", farm.path.stem)
    return {"specificationVersion": "jobtemplate-2023-09", "name": f"eikon {name}"[:120],
            "parameterDefinitions": [{"name": "Farm", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "INOUT",
                                      "default": ".", "description": "The folder that eikon-farm wrote: that of the template"}],
            "steps": steps}


def write_template(options):
    """`openjd`: the folder of a farm, and the template beside its tasks."""
    options.nodes = options.nodes or 1
    farm = submit.read_farm(options)
    submit.measure(farm, options.measure)
    if options.dry_run:
        print(json.dumps(template(farm, len(folder.group(farm, farm.items())), []), indent=1))
        return 0
    submit.check_disk(farm)
    with submit.new_folder(farm):
        submit.write_scripts(farm)
        for name, text in scripts.openjd_scripts(farm).items():
            folder.write(farm.path / name, text, executable=True)
        levels, merges_after = merging.write_merges(farm)
        tasks = folder.write_tasks(farm, farm.items(), merges_after)
        file = farm.path / "job.template.json"
        folder.write(file, json.dumps(template(farm, tasks, levels), indent=1) + "\n")
        farm.save()
    last = f"Merge{len(levels) - 1}" if levels else "Render"
    print(f"run it with: openjd run {file} --step {last} --run-dependencies")
    return 0
