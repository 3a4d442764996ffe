// Made by `cargo xtask unity-border` of crates/lumivox-unity.
using System;
using System.Runtime.InteropServices;

namespace Lumivox.Native
{
    /// <summary>The native library's functions, as its header declares them.</summary>
    internal static unsafe class Library
    {
#if (UNITY_IOS || UNITY_TVOS || UNITY_VISIONOS || UNITY_WEBGL) && !UNITY_EDITOR
        public const string Name = "__Internal";
#else
        public const string Name = "lumivox_unity";
#endif

        [DllImport(Name)] public static extern IntPtr lumivox_text(IntPtr text);
        [DllImport(Name)] public static extern void lumivox_text_free(IntPtr text);
        [DllImport(Name)] public static extern IntPtr lumivox_last_error();
        [DllImport(Name)] public static extern uint lumivox_abi_version();
        [DllImport(Name)] public static extern IntPtr lumivox_version();
        [DllImport(Name)] public static extern int lumivox_check_layout(uint* sizes, uint count);
        [DllImport(Name)] public static extern IntPtr lumivox_volume_phantom(byte* kind, uint size);
        [DllImport(Name)] public static extern IntPtr lumivox_volume_new(uint* dimensions, uint bytesPerVoxel, void* voxels, ulong length, double slope, double intercept, double* patientFromVoxel, uint modality);
        [DllImport(Name)] public static extern IntPtr lumivox_volume_clone(IntPtr volume);
        [DllImport(Name)] public static extern void lumivox_volume_free(IntPtr volume);
        [DllImport(Name)] public static extern int lumivox_volume_info(IntPtr volume, VolumeInfo* @out);
        [DllImport(Name)] public static extern int lumivox_volume_histogram(IntPtr volume, double low, double high, uint bins, float* counts);
        [DllImport(Name)] public static extern IntPtr lumivox_volume_report(IntPtr volume);
        [DllImport(Name)] public static extern void lumivox_set_codec_program(byte* path);
        [DllImport(Name)] public static extern IntPtr lumivox_transfer_function_new(OpacityKnot* knots, uint knotCount, ColorStop* stops, uint stopCount, double shift, double windowScale);
        [DllImport(Name)] public static extern int lumivox_transfer_function_add_gradient(IntPtr function, double perMm, OpacityKnot* knots, uint knotCount, ColorStop* stops, uint stopCount);
        [DllImport(Name)] public static extern uint lumivox_transfer_function_gradient_count(IntPtr function);
        [DllImport(Name)] public static extern IntPtr lumivox_transfer_function_gradient(IntPtr function, uint index, double* perMm);
        [DllImport(Name)] public static extern void lumivox_transfer_function_free(IntPtr function);
        [DllImport(Name)] public static extern int lumivox_transfer_function_sample(IntPtr function, double low, double high, uint count, float* rgba);
        [DllImport(Name)] public static extern IntPtr lumivox_transfer_function_load(byte* file);
        [DllImport(Name)] public static extern int lumivox_transfer_function_save(IntPtr function, byte* file);
        [DllImport(Name)] public static extern uint lumivox_transfer_function_knots(IntPtr function, OpacityKnot* @out, uint capacity);
        [DllImport(Name)] public static extern uint lumivox_transfer_function_stops(IntPtr function, ColorStop* @out, uint capacity);
        [DllImport(Name)] public static extern uint lumivox_preset_count();
        [DllImport(Name)] public static extern IntPtr lumivox_preset_name(uint index);
        [DllImport(Name)] public static extern IntPtr lumivox_preset_description(uint index);
        [DllImport(Name)] public static extern IntPtr lumivox_preset_for(IntPtr volume);
        [DllImport(Name)] public static extern uint lumivox_preset_part(byte* name);
        [DllImport(Name)] public static extern IntPtr lumivox_preset(byte* name, IntPtr volume, Medium* @out);
        [DllImport(Name)] public static extern IntPtr lumivox_map_new(uint width, uint height, float* rgb);
        [DllImport(Name)] public static extern IntPtr lumivox_map_load(byte* file);
        [DllImport(Name)] public static extern int lumivox_map_set_file(IntPtr map, byte* file);
        [DllImport(Name)] public static extern IntPtr lumivox_map_file(IntPtr map);
        [DllImport(Name)] public static extern float* lumivox_map_texels(IntPtr map, uint* size);
        [DllImport(Name)] public static extern void lumivox_map_free(IntPtr map);
        [DllImport(Name)] public static extern IntPtr lumivox_labels_new(uint* dimensions, byte* voxels, ulong length, double* patientFromVoxel, LabelInfo* labels, byte** names, uint count);
        [DllImport(Name)] public static extern int lumivox_labels_count(IntPtr map);
        [DllImport(Name)] public static extern int lumivox_labels_list(IntPtr map, LabelInfo* @out, uint capacity);
        [DllImport(Name)] public static extern IntPtr lumivox_labels_name(IntPtr map, uint index);
        [DllImport(Name)] public static extern double lumivox_labels_share_in(IntPtr map, IntPtr volume);
        [DllImport(Name)] public static extern IntPtr lumivox_labelling_new(IntPtr map, LabelStyle* styles, uint count);
        [DllImport(Name)] public static extern void lumivox_labelling_free(IntPtr labelling);
        [DllImport(Name)] public static extern uint lumivox_volume_skin(IntPtr volume);
        [DllImport(Name)] public static extern IntPtr lumivox_import_scan(byte** paths, uint count, ImportOptions* options);
        [DllImport(Name)] public static extern IntPtr lumivox_import_load(byte** paths, uint count, ImportOptions* options, IntPtr study);
        [DllImport(Name)] public static extern IntPtr lumivox_labels_find(IntPtr volume);
        [DllImport(Name)] public static extern IntPtr lumivox_skin_find(IntPtr volume);
        [DllImport(Name)] public static extern IntPtr lumivox_part_find(IntPtr volume, uint part);
        [DllImport(Name)] public static extern IntPtr lumivox_study_thumbnail(IntPtr study, uint series, uint side);
        [DllImport(Name)] public static extern IntPtr lumivox_volume_picture(IntPtr volume, byte* preset, uint side);
        [DllImport(Name)] public static extern void lumivox_study_free(IntPtr study);
        [DllImport(Name)] public static extern IntPtr lumivox_phantom_start(byte* kind, uint size);
        [DllImport(Name)] public static extern IntPtr lumivox_volume_save(IntPtr volume, byte* file);
        [DllImport(Name)] public static extern int lumivox_stored_copy_nameless(byte* from, byte* to);
        [DllImport(Name)] public static extern IntPtr lumivox_volume_open(byte* file);
        [DllImport(Name)] public static extern IntPtr lumivox_volume_open_bytes(void* data, ulong length);
        [DllImport(Name)] public static extern JobState lumivox_job_poll(IntPtr job, Progress* @out);
        [DllImport(Name)] public static extern void lumivox_job_cancel(IntPtr job);
        [DllImport(Name)] public static extern void lumivox_job_free(IntPtr job);
        [DllImport(Name)] public static extern IntPtr lumivox_job_error(IntPtr job);
        [DllImport(Name)] public static extern IntPtr lumivox_job_take_volume(IntPtr job);
        [DllImport(Name)] public static extern IntPtr lumivox_job_take_study(IntPtr job);
        [DllImport(Name)] public static extern IntPtr lumivox_job_report(IntPtr job);
        [DllImport(Name)] public static extern int lumivox_job_picture(IntPtr job, Picture* @out);
        [DllImport(Name)] public static extern uint lumivox_jobs_running();
        [DllImport(Name)] public static extern void lumivox_jobs_stop_all();
        [DllImport(Name)] public static extern IntPtr lumivox_scene_open(byte* file, uint allowOutsideData);
        [DllImport(Name)] public static extern IntPtr lumivox_job_take_scene(IntPtr job);
        [DllImport(Name)] public static extern int lumivox_scene_is_one(byte* file);
        [DllImport(Name)] public static extern void lumivox_scene_free(IntPtr scene);
        [DllImport(Name)] public static extern IntPtr lumivox_scene_notes(IntPtr scene);
        [DllImport(Name)] public static extern IntPtr lumivox_scene_document(IntPtr scene);
        [DllImport(Name)] public static extern IntPtr lumivox_scene_files(IntPtr scene);
        [DllImport(Name)] public static extern uint lumivox_scene_volume_count(IntPtr scene);
        [DllImport(Name)] public static extern IntPtr lumivox_scene_volume(IntPtr scene, uint index);
        [DllImport(Name)] public static extern IntPtr lumivox_scene_labels(IntPtr scene, uint index);
        [DllImport(Name)] public static extern IntPtr lumivox_scene_transfer_function(IntPtr scene, uint index);
        [DllImport(Name)] public static extern int lumivox_scene_instance(IntPtr scene, uint index, Instance* @out, ObjectPose* pose);
        [DllImport(Name)] public static extern int lumivox_scene_clip(IntPtr scene, uint index, uint clip, ClipShape* @out, ObjectPose* pose);
        [DllImport(Name)] public static extern uint lumivox_scene_style_count(IntPtr scene, uint index);
        [DllImport(Name)] public static extern int lumivox_scene_style(IntPtr scene, uint index, uint style, LabelStyle* @out);
        [DllImport(Name)] public static extern int lumivox_scene_view(IntPtr scene, SavedView* @out, ObjectPose* pose);
        [DllImport(Name)] public static extern uint lumivox_scene_light_count(IntPtr scene);
        [DllImport(Name)] public static extern int lumivox_scene_light(IntPtr scene, uint index, LightSource* @out, ObjectPose* pose);
        [DllImport(Name)] public static extern int lumivox_scene_environment(IntPtr scene, Surroundings* @out);
        [DllImport(Name)] public static extern int lumivox_stage_save_world(IntPtr stage, ulong world, SavedView* view, float radiance, byte* opened, byte* file);
        [DllImport(Name)] public static extern uint lumivox_kernel_count();
        [DllImport(Name)] public static extern IntPtr lumivox_kernel_name(uint index);
        [DllImport(Name)] public static extern Step* lumivox_recording_steps(IntPtr recording, uint* count);
        [DllImport(Name)] public static extern IntPtr lumivox_stage_new(DeviceLimits* limits);
        [DllImport(Name)] public static extern void lumivox_stage_free(IntPtr stage);
        [DllImport(Name)] public static extern void lumivox_stage_begin_frame(IntPtr stage);
        [DllImport(Name)] public static extern int lumivox_stage_set_world(IntPtr stage, ulong world, Instance* instances, uint instanceCount, ClipShape* clips, uint clipCount, LightSource* lights, uint lightCount, Surroundings* environment);
        [DllImport(Name)] public static extern IntPtr lumivox_stage_record_world(IntPtr stage, ulong world, uint atOnce);
        [DllImport(Name)] public static extern IntPtr lumivox_stage_record_view(IntPtr stage, ulong view, ulong world, ViewFrame* frame, ViewStatus* @out);
        [DllImport(Name)] public static extern int lumivox_recording_finish(IntPtr stage, IntPtr recording, uint outcome, byte* why);
        [DllImport(Name)] public static extern void lumivox_stage_feedback(IntPtr stage, ulong ticket, void* bytes, ulong length);
        [DllImport(Name)] public static extern void lumivox_stage_measured(IntPtr stage, ulong ticket, double milliseconds);
        [DllImport(Name)] public static extern int lumivox_stage_view_status(IntPtr stage, ulong view, ViewStatus* @out);
        [DllImport(Name)] public static extern IntPtr lumivox_stage_sweep(IntPtr stage, ulong* views, uint viewCount, ulong* worlds, uint worldCount);
        [DllImport(Name)] public static extern ulong lumivox_stage_voxel_bytes(IntPtr stage);
        [DllImport(Name)] public static extern ulong lumivox_stage_light_bytes(IntPtr stage);
        [DllImport(Name)] public static extern int lumivox_volume_resolution(IntPtr stage, IntPtr volume, uint* factor, uint* arriving);
        [DllImport(Name)] public static extern uint lumivox_stage_world_progress(IntPtr stage, ulong world);
    }
}
