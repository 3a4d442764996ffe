@tool
extends Node
## Imports a folder of DICOM files again when they are no longer those that its scan was made of.
##
## Godot looks at each file on its own. A folder is one scan that is imported with its first file, and files that are
## copied later, replaced or removed change it too: a scan that lacks half its slices must not look complete. What a
## scan was made of is kept beside the editor's own state, in `.godot/editor`.

const VolumeImporter := preload("import_plugin.gd")

## Where what scans were made of is kept between sessions.
const STATE_FILE := "lumivox_folders"
## Between two looks at a folder whose files may still be arriving.
const LOOK_SECONDS := 0.5
## A folder is at rest when its files have been the same for so long.
const SETTLE_MS := 2000
## Where a DICOM file says that it is one, and how.
const PREAMBLE := 128
const MAGIC := "DICM"

## By folder: what its scan was made of. `first` is the file it was imported with, `options` how, `files` is a
## [method listing], and `moved_from` is the first file before, while others still point there.
static var _made_of: Dictionary = {}
static var _is_read := false
static var _first_files: Dictionary[String, String] = {}
## Folders that were imported since they were looked at.
static var _fresh: Dictionary[String, bool] = {}
## Files that Godot found to have other contents, by folder.
static var _touched: Dictionary[String, Dictionary] = {}
## By path: size, time, and whether that file is DICOM by its contents.
static var _looked_into: Dictionary[String, Array] = {}

## Folders that may still change, with their last listing and when it was new.
var _waiting: Dictionary[String, Dictionary] = {}
## The listings that the editor was asked to look for, and to import: once each, whatever comes of it.
var _scanned: Dictionary[String, Dictionary] = {}
var _asked: Dictionary[String, Dictionary] = {}
var _timer := Timer.new()
## Progress bars keep timers going while the editor imports.
var _importing := false


func _init() -> void:
	_timer.wait_time = LOOK_SECONDS
	_timer.timeout.connect(_on_timeout)
	add_child(_timer)


func _enter_tree() -> void:
	var files := EditorInterface.get_resource_filesystem()
	files.filesystem_changed.connect(_on_filesystem_changed)
	files.resources_reimporting.connect(_on_reimporting)
	files.resources_reimported.connect(_on_reimported)


func _exit_tree() -> void:
	var files := EditorInterface.get_resource_filesystem()
	files.filesystem_changed.disconnect(_on_filesystem_changed)
	files.resources_reimporting.disconnect(_on_reimporting)
	files.resources_reimported.disconnect(_on_reimported)


## Whether no folder is waited for.
func is_at_rest() -> bool:
	return _waiting.is_empty() and not _importing


## The file that a folder's scan is imported with: its first one by name.
static func first_file(folder: String) -> String:
	if not _first_files.has(folder):
		# Listed once: a scan may have thousands of files, and each asks.
		var files := dicom_files(folder)
		_first_files[folder] = files[0] if not files.is_empty() else ""
	return _first_files[folder]


## The files in a folder that are imported as DICOM, by name.
static func dicom_files(folder: String) -> Array[String]:
	var files: Array[String] = []
	for name in DirAccess.get_files_at(folder) if DirAccess.dir_exists_absolute(folder) else PackedStringArray():
		if name.get_extension().to_lower() in ["dcm", "dicom"]:
			files.append(folder.path_join(name))
	files.sort_custom(func(a: String, b: String) -> bool: return a.naturalnocasecmp_to(b) < 0)
	return files


## Told before a folder's scan is imported: if that fails, the same files are not tried again.
static func remember(folder: String, first: String, options: Dictionary) -> void:
	_read()
	var made := {"first": first, "options": options, "files": listing(folder)}
	var before: Dictionary = _made_of.get(folder, {})
	if before.get("first", first) != first:
		made.moved_from = before.first
		made.options_before = before.options
	_made_of[folder] = made
	_fresh[folder] = true
	_write()


## Told when a file that only points to its folder's scan is imported.
static func touch(file: String) -> void:
	_touched.get_or_add(file.get_base_dir(), {})[file] = true


## Size and time of each file that a scan in [param folder] may be read from, by its path within.
static func listing(folder: String) -> Dictionary:
	var found := {}
	var folders: Array[String] = []
	if DirAccess.dir_exists_absolute(folder):
		folders.append("")
	while not folders.is_empty():
		var within: String = folders.pop_back()
		var inside := DirAccess.open(folder.path_join(within))
		if inside == null:
			continue
		for name in inside.get_directories():
			# A link may lead anywhere, in circles too.
			if not inside.is_link(name):
				folders.append(within.path_join(name))
		for name in inside.get_files():
			var path := folder.path_join(within).path_join(name)
			var seen := [FileAccess.get_size(path), FileAccess.get_modified_time(path)]
			if _may_be_dicom(path, seen):
				found[within.path_join(name)] = seen
	return found


## Whether a scan may be read from a file, by its name, or by its contents where its name says nothing: scanners leave
## the extension out, or end names with a UID's number.
static func _may_be_dicom(path: String, seen: Array) -> bool:
	var extension := path.get_extension().to_lower()
	if extension in ["dcm", "dicom", "ima"]:
		return true
	if extension != "" and not extension.is_valid_int():
		return false
	if _looked_into.get(path, [0, 0, false]).slice(0, 2) != seen:
		var file := FileAccess.open(path, FileAccess.READ)
		if file != null:
			file.seek(PREAMBLE)
		var is_dicom := file != null and file.get_buffer(MAGIC.length()).get_string_from_ascii() == MAGIC
		_looked_into[path] = seen + [is_dicom]
	return _looked_into[path][2]


func _on_filesystem_changed() -> void:
	_first_files.clear()
	_read()
	for folder: String in _made_of.keys():
		# Importing one comes back here, and may find that another is gone.
		if not _made_of.has(folder):
			continue
		var now := listing(folder)
		if not _differs(folder, now) and not _fresh.has(folder):
			_touched.erase(folder)
			continue
		if DisplayServer.get_name() == "headless":
			# Nobody copies files there, and what only imports ends now.
			_update(folder, now)
		elif not _waiting.has(folder):
			_waiting[folder] = {"files": now, "since": Time.get_ticks_msec()}
	_fresh.clear()
	if not _waiting.is_empty() and _timer.is_stopped():
		_timer.start()


func _on_reimporting(_files: PackedStringArray) -> void:
	_first_files.clear()
	_importing = true


func _on_reimported(_files: PackedStringArray) -> void:
	_importing = false


func _on_timeout() -> void:
	if _importing or EditorInterface.get_resource_filesystem().is_scanning():
		return
	for folder: String in _waiting.keys():
		var now := listing(folder)
		if now != _waiting[folder].files:
			_waiting[folder] = {"files": now, "since": Time.get_ticks_msec()}
		elif Time.get_ticks_msec() - (_waiting[folder].since as int) >= SETTLE_MS:
			_waiting.erase(folder)
			_update(folder, now)
			# What it set off comes back as a change.
			break
	if _waiting.is_empty():
		_timer.stop()


## Whether a folder's scan was made of other files than those that are there now.
static func _differs(folder: String, now: Dictionary) -> bool:
	var made: Dictionary = _made_of[folder]
	if made.has("moved_from") or made.files.size() != now.size():
		return true
	for name: String in now:
		var before: Array = made.files.get(name, [-1, 0])
		# A time alone says little: copies of a project have others. Godot compares contents then.
		var path := folder.path_join(name)
		var is_touched := (_touched.get(path.get_base_dir(), {}) as Dictionary).has(path)
		if before[0] != now[name][0] or (before[1] != now[name][1] and is_touched):
			return true
	return false


## Imports a folder whose files rest, if its scan was made of others.
func _update(folder: String, now: Dictionary) -> void:
	_first_files.erase(folder)
	var first := first_file(folder)
	if first == "":
		_made_of.erase(folder)
		_write()
		return
	if not _made_of.has(folder) or not _differs(folder, now) or _asked.get(folder, {}) == now:
		return
	var files := EditorInterface.get_resource_filesystem()
	var own := dicom_files(folder)
	var is_known := func(path: String) -> bool: return files.get_file_type(path) != ""
	if not own.all(is_known) and _scanned.get(folder, {}) != now:
		_scanned[folder] = now
		files.scan()
		return
	if not _is_imported_here(first):
		return
	_asked[folder] = now
	var made: Dictionary = _made_of[folder]
	var was_first: String = made.get("moved_from", made.first)
	var wanted := PackedStringArray([first])
	if was_first != first:
		wanted = PackedStringArray(own.filter(is_known))
		var inherits := _inherit_options(first, made.get("options_before", made.options) as Dictionary)
		if made.has("moved_from") and not inherits and made.files == now:
			# It was imported already, when it came.
			wanted.remove_at(wanted.find(first))
		push_warning("Lumivox: the scan in %s is now imported as %s, which comes first. What shows %s is to be given that." % [
			folder, first.get_file(), was_first.get_file()])
	else:
		var what := "files were replaced" if made.files.size() == now.size() \
				else "it had %d files and has %d now" % [made.files.size(), now.size()]
		print("Lumivox: %s is imported again: %s." % [folder, what])
	files.reimport_files(wanted)
	_touched.erase(folder)
	(_made_of[folder] as Dictionary).erase("moved_from")
	_write()


## Whether a file is imported as DICOM, and not kept as it is.
func _is_imported_here(path: String) -> bool:
	var settings := ConfigFile.new()
	return settings.load(path + ".import") == OK and settings.get_value("remap", "importer", "") == "lumivox.dicom"


## Gives a folder's new first file the options of the one before, unless it has its own. Returns whether it did.
func _inherit_options(first: String, before: Dictionary) -> bool:
	var settings := ConfigFile.new()
	if settings.load(first + ".import") != OK:
		return false
	var own := {}
	for key in settings.get_section_keys("params") if settings.has_section("params") else PackedStringArray():
		own[key] = settings.get_value("params", key)
	for option in VolumeImporter.series_options() + VolumeImporter.value_options() + VolumeImporter.content_options():
		if own.get(option.name, option.default_value) != option.default_value:
			return false
	var differs := false
	for key: String in before:
		differs = differs or own.get(key) != before[key]
		settings.set_value("params", key, before[key])
	return differs and settings.save(first + ".import") == OK


static func _state_path() -> String:
	return EditorInterface.get_editor_paths().get_project_settings_dir().path_join(STATE_FILE)


static func _read() -> void:
	if _is_read:
		return
	_is_read = true
	var file := FileAccess.open(_state_path(), FileAccess.READ) if FileAccess.file_exists(_state_path()) else null
	var read: Variant = file.get_var() if file != null and file.get_length() > 0 else null
	_made_of = read as Dictionary if read is Dictionary else {}


static func _write() -> void:
	var file := FileAccess.open(_state_path(), FileAccess.WRITE)
	if file != null:
		file.store_var(_made_of)
	else:
		push_warning("Lumivox: what scans were made of cannot be kept in %s: %s." % [
			_state_path(), error_string(FileAccess.get_open_error())])
